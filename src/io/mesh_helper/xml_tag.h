/* Tags of XML and their attributes, as much as is needed to see what Assimp does not. Part of
 * raykit-mesh. */
#ifndef RK_IO_MESH_HELPER_XML_TAG_H
#define RK_IO_MESH_HELPER_XML_TAG_H

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef struct xml_span {
    const char *from, *to;
} xml_span;

static inline bool xml_is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* `tag` begins with its bracket; the name of a closing one, with its slash. */
static inline bool xml_is_tag(xml_span tag, const char *name)
{
    const size_t length = strlen(name);
    return (size_t)(tag.to - tag.from) > length + 1 && memcmp(tag.from + 1, name, length) == 0 &&
           (xml_is_blank(tag.from[length + 1]) || tag.from[length + 1] == '/' ||
            tag.from[length + 1] == '>');
}

/* The next tag, up to its last bracket, or comment or CDATA section, whose signs mean nothing.
 * False at the end. */
static inline bool xml_next_tag(const char **at, const char *end, xml_span *tag)
{
    static const char comment[] = "<!--", section[] = "<![CDATA[";
    tag->from = memchr(*at, '<', (size_t)(end - *at));
    if (!tag->from)
        return false;
    const bool is_comment = end - tag->from > 4 && memcmp(tag->from, comment, 4) == 0;
    const bool is_section = end - tag->from > 9 && memcmp(tag->from, section, 9) == 0;
    const char *const close = is_comment ? "--" : is_section ? "]]" : NULL;
    char quote = '\0';
    for (const char *c = tag->from; c < end; c++) {
        if (close ? *c == '>' && memcmp(c - 2, close, 2) == 0 : *c == '>' && !quote) {
            *at = tag->to = c + 1;
            return true;
        }
        if (!close && (quote ? *c == quote : *c == '"' || *c == '\''))
            quote = quote ? '\0' : *c;
    }
    return false;
}

/* Finds its value, without the quotes. */
static inline bool xml_find_attribute(xml_span tag, const char *name, xml_span *value)
{
    const size_t length = strlen(name);
    for (const char *c = tag.from; c < tag.to; c++) {
        const bool is_it = (size_t)(tag.to - c) > length + 3 && xml_is_blank(c[0]) &&
                           memcmp(c + 1, name, length) == 0 &&
                           (c[length + 1] == '=' || xml_is_blank(c[length + 1]));
        if (is_it) {
            const char *from = c + 1 + length;
            from += strspn(from, " \t\r\n="); /* ends at the tag's bracket */
            const char *to = memchr(from + 1, *from, (size_t)(tag.to - from - 1));
            *value = (xml_span){from + 1, to};
            return to && strchr("\"'", *from);
        }
        if (*c == '"' || *c == '\'') { /* another's value */
            const char *close = memchr(c + 1, *c, (size_t)(tag.to - c - 1));
            c = close ? close : tag.to - 1;
        }
    }
    return false;
}

static inline bool xml_is_text(xml_span span, const char *text)
{
    const size_t length = strlen(text);
    return (size_t)(span.to - span.from) == length && memcmp(span.from, text, length) == 0;
}

static inline double xml_number(xml_span value)
{
    char number[32] = {0};
    const size_t length = (size_t)(value.to - value.from);
    memcpy(number, value.from, length < 31 ? length : 31);
    return strtod(number, NULL);
}

#endif
