/* Packets: four rays of nearly the same direction traverse a tree together. A box or a triangle is
 * fetched once, and tested against all four at once (after Wald, Slusallek, Benthin, Wagner,
 * "Interactive rendering with coherent ray tracing", Eurographics 2001); not installed. */
#ifndef RK_ACCEL_PACKET_H
#define RK_ACCEL_PACKET_H

#include "base/counters.h"
#include "scene/bvh.h"

#include <stdbool.h>

enum { RK_PACKET_MAX = 4 };

/* Up to RK_PACKET_MAX rays; the same results as of rk_bvh_closest and rk_bvh_occluded. A test of a
 * box or a triangle counts once for all rays. */
void rk_packet_closest(const rk_bvh *bvh, const rk_ray *rays, uint32_t count, rk_hit *hits,
                       rk_counters *counters);
void rk_packet_occluded(const rk_bvh *bvh, const rk_ray *rays, uint32_t count, bool *occluded,
                        rk_counters *counters);

#endif
