/* Walks through JSON whose syntax Assimp checks: of a broken text anything is found, but nothing is
 * read beyond its end. Part of raykit-mesh. Format: RFC 8259. */
#ifndef RK_IO_MESH_HELPER_JSON_CURSOR_H
#define RK_IO_MESH_HELPER_JSON_CURSOR_H

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

/* `at` stays within the text. */
typedef struct json_cursor {
    const char *at, *end;
} json_cursor;

typedef struct json_string {
    const char *begin;
    size_t length;
} json_string;

static inline bool json_equals(const json_string *string, const char *other)
{
    return string->length == strlen(other) && memcmp(string->begin, other, string->length) == 0;
}

/* From one quotation mark to the other. */
static inline json_string json_read_string(json_cursor *c)
{
    const char *begin = ++c->at;
    while (c->at < c->end && *c->at != '"')
        c->at += *c->at == '\\' && c->end - c->at > 1 ? 2 : 1;
    const json_string string = {begin, (size_t)(c->at - begin)};
    c->at += c->at < c->end;
    return string;
}

static inline void json_skip_blanks(json_cursor *c)
{
    while (c->at < c->end && strchr(" \t\r\n,:", *c->at) && *c->at)
        c->at++;
}

/* Enters an object or a list; false if the value is another. */
static inline bool json_enter(json_cursor *c, char bracket)
{
    json_skip_blanks(c);
    if (c->at == c->end || *c->at != bracket)
        return false;
    c->at++;
    return true;
}

/* Moves to the next value of the list; false at its end, which is left. */
static inline bool json_next(json_cursor *c)
{
    json_skip_blanks(c);
    if (c->at == c->end)
        return false;
    if (*c->at != ']' && *c->at != '}')
        return true;
    c->at++;
    return false;
}

/* Moves to the next value of the object, and gives its key. */
static inline bool json_next_key(json_cursor *c, json_string *key)
{
    if (!json_next(c) || *c->at != '"')
        return false;
    *key = json_read_string(c);
    json_skip_blanks(c);
    return c->at < c->end;
}

/* Moves behind the value. */
static inline void json_skip(json_cursor *c)
{
    json_skip_blanks(c);
    for (int depth = 0; c->at < c->end;) {
        const char here = *c->at;
        if (depth == 0 && (!here || strchr(" \t\r\n,]}", here)))
            return;
        if (here == '"')
            json_read_string(c);
        else
            c->at++;
        depth += here == '{' || here == '[';
        depth -= here == '}' || here == ']';
        if (depth == 0 && (here == '"' || here == '}' || here == ']'))
            return;
    }
}

/* Moves to the value of this key of the outermost object. */
static inline bool json_find_key(json_cursor *c, const char *key)
{
    json_string found;
    if (!json_enter(c, '{'))
        return false;
    for (; json_next_key(c, &found); json_skip(c))
        if (json_equals(&found, key))
            return true;
    return false;
}

/* Reads a number that is not negative and below 2^32; `otherwise` for any other value. */
static inline long long json_read_index(json_cursor *c, long long otherwise)
{
    json_skip_blanks(c);
    const char *from = c->at;
    long long value = 0;
    for (; c->at < c->end && *c->at >= '0' && *c->at <= '9' && value <= 0xffffffff; c->at++)
        value = 10 * value + (*c->at - '0');
    const bool is_number = c->at > from && value <= 0xffffffff;
    if (!is_number)
        json_skip(c);
    return is_number ? value : otherwise;
}

#endif
