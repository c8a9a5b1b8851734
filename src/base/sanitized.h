/* Defines RK_SANITIZED in builds with a sanitizer of addresses or threads: gcc and clang announce
 * it differently. Memory takes long there, and terabytes of addresses are reserved; not installed.
 */
#ifndef RK_BASE_SANITIZED_H
#define RK_BASE_SANITIZED_H

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define RK_SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define RK_SANITIZED
#endif

#endif
