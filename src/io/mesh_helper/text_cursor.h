/* Reads text that need not end in NUL: counts lines, and parses numbers strictly. */
#ifndef RK_IO_MESH_HELPER_TEXT_CURSOR_H
#define RK_IO_MESH_HELPER_TEXT_CURSOR_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

typedef struct text_cursor {
    const char *at, *end;
    size_t line; /* from 1 */
} text_cursor;

static inline text_cursor text_begin(const char *text, size_t size)
{
    text_cursor c = {text, text + size, 1};
    /* Skip the byte order mark that some editors write before UTF-8. */
    if (size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0)
        c.at += 3;
    return c;
}

/* Skips spaces, and line breaks after a backslash, as in OBJ. */
static inline void text_skip_blanks(text_cursor *c)
{
    for (; c->at < c->end; c->at++) {
        if (*c->at == ' ' || *c->at == '\t' || *c->at == '\r')
            continue;
        bool hidden =
            *c->at == '\\' && c->end - c->at > 1 &&
            (c->at[1] == '\n' || (c->at[1] == '\r' && c->end - c->at > 2 && c->at[2] == '\n'));
        if (!hidden)
            return;
        c->at += c->at[1] == '\n' ? 1 : 2;
        c->line++;
    }
}

/* After blanks, is nothing left in this line except perhaps a comment? */
static inline bool text_line_ended(text_cursor *c)
{
    text_skip_blanks(c);
    return c->at == c->end || *c->at == '\n' || *c->at == '#';
}

static inline void text_next_line(text_cursor *c)
{
    const char *newline = memchr(c->at, '\n', (size_t)(c->end - c->at));
    c->at = newline ? newline + 1 : c->end;
    c->line += newline != NULL;
}

/* Moves to the next line with more than blanks and a comment; false at the end of the text. */
static inline bool text_next_content(text_cursor *c)
{
    while (text_line_ended(c)) {
        if (c->at == c->end)
            return false;
        text_next_line(c);
    }
    return true;
}

static inline bool text_is_separator(const text_cursor *c)
{
    return c->at == c->end || *c->at == ' ' || *c->at == '\t' || *c->at == '\n' || *c->at == '\r' ||
           *c->at == '#' || *c->at == '\\';
}

static inline size_t text_skip_digits(text_cursor *c)
{
    const char *from = c->at;
    while (c->at < c->end && *c->at >= '0' && *c->at <= '9')
        c->at++;
    return (size_t)(c->at - from);
}

/* Reads a decimal number that is finite as a float. Only a long one or one with an exponent may not
 * be, so only these are converted. */
static inline bool text_read_finite(text_cursor *c)
{
    text_skip_blanks(c);
    const char *from = c->at;
    if (c->at < c->end && (*c->at == '-' || *c->at == '+'))
        c->at++;
    size_t whole = text_skip_digits(c), fraction = 0;
    if (c->at < c->end && *c->at == '.') {
        c->at++;
        fraction = text_skip_digits(c);
    }
    if (whole + fraction == 0)
        return false;
    bool scaled = c->at < c->end && (*c->at == 'e' || *c->at == 'E');
    if (scaled) {
        c->at++;
        if (c->at < c->end && (*c->at == '-' || *c->at == '+'))
            c->at++;
        if (text_skip_digits(c) == 0)
            return false;
    }
    if (!text_is_separator(c))
        return false;
    if (!scaled && whole < 38)
        return true;
    char number[400];
    size_t length = (size_t)(c->at - from);
    if (length >= sizeof number)
        return false;
    memcpy(number, from, length);
    number[length] = '\0';
    return isfinite(strtof(number, NULL));
}

/* Reads an integer of up to 18 digits; the caller checks the character after it. */
static inline bool text_read_integer(text_cursor *c, long long *value)
{
    bool negative = c->at < c->end && *c->at == '-';
    if (c->at < c->end && (*c->at == '-' || *c->at == '+'))
        c->at++;
    const char *from = c->at;
    size_t digits = text_skip_digits(c);
    if (digits == 0 || digits > 18)
        return false;
    *value = 0;
    for (; from < c->at; from++)
        *value = *value * 10 + (*from - '0');
    if (negative)
        *value = -*value;
    return true;
}

/* Reads a word up to the next separator, truncated to fit. Returns false at the end of the line. */
static inline bool text_read_word(text_cursor *c, char *word, size_t size)
{
    if (text_line_ended(c))
        return false;
    size_t length = 0;
    for (; !text_is_separator(c); c->at++)
        if (length < size - 1)
            word[length++] = *c->at;
    if (length == 0) /* a lone backslash */
        c->at++;
    word[length] = '\0';
    return true;
}

#endif
