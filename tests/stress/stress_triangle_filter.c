/* Does the float test that comes first ever reject a triangle that the careful test hits? Leaves of
 * triangles around a common edge, with coordinates of every kind, are tested as traversals test
 * them, four triangles or four rays at once, and by the careful test alone: the same hits, to the
 * bit. RAYKIT_STRESS is the factor over make check, which tests 10,000 leaves, 200,000 pairs of ray
 * and triangle. */
#include "../test.h"

#include "accel/kernel/wide_kernel.h"
#include "base/random.h"
#include "features/watertight.h"

#include <float.h>

enum { leaf_max = 9, ray_count = 4 };

static uint32_t leaf_count(void)
{
    const char *factor = getenv("RAYKIT_STRESS");
    return 10000 * (uint32_t)(factor ? strtoul(factor, NULL, 10) : 1);
}

/* --- Numbers ---------------------------------------------------------------------------------- */

typedef struct source {
    uint32_t key, draws;
    enum { WHOLE, FRACTIONS, NEIGHBOURS, ANY_EXPONENT, SPECIAL } kind;
    int exponent; /* common to all numbers of the first three kinds */
    int most;     /* of whole numbers; a few only, and rays lie in planes, too */
} source;

static uint32_t bits(source *s)
{
    return rk_hash(0x66696c74, s->key, s->draws++, 0);
}

static int between(source *s, int low, int high)
{
    return low + (int)(bits(s) % (uint32_t)(high - low + 1));
}

static float number(source *s)
{
    static const float special[] = {0,        -0.0f,   0x1p-149f, FLT_MIN, FLT_MAX,
                                    -FLT_MAX, 0x1p64f, NAN,       INFINITY};
    float fraction = 2 * rk_unit_float(bits(s)) - 1;
    switch (s->kind) {
    case WHOLE: /* sums and halves are exact: rays pass exactly through edges */
        return ldexpf((float)between(s, -s->most, s->most), s->exponent);
    case NEIGHBOURS:
        return ldexpf(1 + (float)between(s, 0, 8) * 0x1p-23f, s->exponent);
    case ANY_EXPONENT:
        return ldexpf(fraction, between(s, -149, 128));
    case SPECIAL:
        if (bits(s) % 40 == 0)
            return special[bits(s) % (sizeof special / sizeof *special)];
        return fraction;
    default:
        return ldexpf(fraction, s->exponent);
    }
}

static rk_vec3 vector(source *s)
{
    float x = number(s), y = number(s);
    return rk_vec(x, y, number(s));
}

static float nudged(source *s, float x)
{
    uint32_t way = bits(s) % 4;
    return way == 0 ? nextafterf(x, INFINITY) : way == 1 ? nextafterf(x, -INFINITY) : x;
}

static rk_vec3 nudged3(source *s, rk_vec3 v)
{
    float x = nudged(s, v.x), y = nudged(s, v.y);
    return rk_vec(x, y, nudged(s, v.z));
}

/* --- Leaves and rays -------------------------------------------------------------------------- */

typedef struct leaf_case {
    uint32_t count;
    rk_triangle leaf[leaf_max];
    rk_ray rays[ray_count];
} leaf_case;

/* Up to the hit of the first triangle, a little less or more, or anywhere. */
static float t_max_of(source *s, const rk_triangle *triangle, const rk_ray *ray)
{
    float t = rk_watertight_intersect(triangle, ray).t;
    switch (bits(s) % 4) {
    case 0:
        return INFINITY;
    case 1:
        return fabsf(number(s));
    default:
        return t < INFINITY ? fmaxf(nudged(s, t), 0) : t;
    }
}

/* Numbers of any exponent are few: their exact sums are long, and take most of the time. */
static leaf_case case_of(uint32_t key)
{
    source s = {.key = key, .kind = key % 16 < 2 ? ANY_EXPONENT + key % 16 : key % 3};
    leaf_case c = {.count = 1 + bits(&s) % leaf_max};
    s.exponent = between(&s, 0, 3) ? between(&s, -145, 100) : 0;
    s.most = 1 << between(&s, 2, 20);
    rk_vec3 a = vector(&s), b = vector(&s), origin = vector(&s);
    for (uint32_t i = 0; i < c.count; i++)
        c.leaf[i] = bits(&s) % 2 ? (rk_triangle){a, b, vector(&s), 100 - i}
                                 : (rk_triangle){vector(&s), b, a, 100 - i};
    float part = rk_unit_float(bits(&s));
    rk_vec3 in_first = rk_mix(rk_mix(a, b, 0.5f), c.leaf[0].c, part), to = in_first;
    switch (bits(&s) % 5) {
    case 0:
        to = a;
        break;
    case 1:
        to = rk_scale(rk_add(a, b), 0.5f);
        break;
    case 2:
        to = rk_mix(a, b, part);
        break;
    case 3: /* from the surface */
        to = origin, origin = in_first;
        break;
    default:
        break;
    }
    float length = between(&s, 0, 1) ? ldexpf(1, between(&s, -60, 60)) : 1;
    rk_vec3 direction = rk_scale(rk_sub(to, origin), length);
    for (uint32_t i = 0; i < ray_count; i++) {
        rk_vec3 d = i == 0 ? direction : nudged3(&s, direction);
        c.rays[i] = (rk_ray){i < 2 ? origin : nudged3(&s, origin), d, INFINITY};
        c.rays[i].t_max = t_max_of(&s, &c.leaf[0], &c.rays[i]);
    }
    return c;
}

/* --- The same hits ---------------------------------------------------------------------------- */

static rk_hit careful_closest(const leaf_case *c, const rk_ray *ray, uint32_t *first)
{
    rk_hit hit = {ray->t_max, 0, 0, RK_MISS};
    *first = c->count;
    for (uint32_t i = 0; i < c->count; i++) {
        rk_triangle_closest(&c->leaf[i], ray, &hit);
        if (*first == c->count && rk_triangle_occludes(&c->leaf[i], ray))
            *first = i;
    }
    return hit;
}

static bool same(const rk_hit *a, const rk_hit *b)
{
    return a->triangle == b->triangle &&
           (a->triangle == RK_MISS || (a->t == b->t && a->u == b->u && a->v == b->v));
}

/* A tree of one leaf, in a box without end; its own box is what its corners need. */
static rk_wide_bvh wide_leaf_of(const leaf_case *c)
{
    static rk_wide_block blocks[(leaf_max + RK_WIDE_BLOCK - 1) / RK_WIDE_BLOCK];
    static rk_wide_node root;
    const uint32_t count = (c->count + RK_WIDE_BLOCK - 1) / RK_WIDE_BLOCK;
    rk_wide_bvh wide = {.node_count = 1,
                        .block_count = count,
                        .triangle_count = c->count,
                        .box = rk_box_empty(),
                        .nodes = &root,
                        .blocks = blocks};
    for (uint32_t i = 0; i < count * RK_WIDE_BLOCK; i++) {
        const rk_triangle *triangle = &c->leaf[i < c->count ? i : c->count - 1];
        const rk_vec3 corners[3] = {triangle->a, triangle->b, triangle->c};
        rk_wide_block *block = &blocks[i / RK_WIDE_BLOCK];
        block->index[i % RK_WIDE_BLOCK] = triangle->index;
        for (int k = 0; k < 3; k++) {
            wide.box.corner[0] = rk_min3(wide.box.corner[0], corners[k]);
            wide.box.corner[1] = rk_max3(wide.box.corner[1], corners[k]);
            for (int axis = 0; axis < 3; axis++)
                block->corner[k][axis][i % RK_WIDE_BLOCK] = rk_axis(corners[k], axis);
        }
    }
    for (uint32_t i = 0; i < count; i++)
        rk_wide_block_finish(&blocks[i]);
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++) {
        root.child[i] = i == 0 ? rk_wide_leaf(0, count) : rk_wide_leaf(0, 0);
        for (int axis = 0; axis < 3; axis++) {
            root.side[0][axis][i] = i == 0 ? -INFINITY : INFINITY;
            root.side[1][axis][i] = i == 0 ? INFINITY : -INFINITY;
        }
    }
    rk_wide_node_finish(&root);
    return wide;
}

/* With the instructions of every set that the machine has. */
static void check_wide(const leaf_case *c, const rk_hit *want, uint32_t key)
{
    static const char *const isas[] = {"scalar", "sse2", "avx2", "avx512"};
    const rk_wide_bvh wide = wide_leaf_of(c);
    rk_ray_batch rays;
    rays.count = 0;
    for (uint32_t i = 0; i < ray_count; i++)
        rk_batch_push(&rays, &c->rays[i]);
    for (int k = 0; k < 4; k++) {
        const rk_wide_kernel *kernel = rk_wide_kernel_named(isas[k], NULL);
        rk_counters counters = {0};
        rk_hit_batch hits;
        rk_occlusion_batch answers;
        if (!kernel)
            continue;
        kernel->closest(&wide, &rays, &hits, &counters);
        kernel->occluded(&wide, &rays, &answers, &counters);
        for (uint32_t i = 0; i < ray_count; i++) {
            rk_hit got = rk_batch_hit(&hits, i);
            rk_check(same(&got, &want[i]), "leaf %u, ray %u: with %s %u is hit, carefully %u", key,
                     i, isas[k], got.triangle, want[i].triangle);
            rk_check(answers.occluded[i] == (want[i].triangle != RK_MISS),
                     "leaf %u, ray %u: occlusion with %s", key, i, isas[k]);
        }
    }
}

static void float_rejects_only_what_the_careful_test_misses(void **state)
{
    (void)state;
    unsigned long long pairs = 0, hits = 0;
    for (uint32_t key = 0; key < leaf_count(); key++) {
        leaf_case c = case_of(key);
        rk_hit want[ray_count];
        for (uint32_t i = 0; i < ray_count; i++) {
            uint32_t first;
            const rk_ray *ray = &c.rays[i];
            rk_hit got = {ray->t_max, 0, 0, RK_MISS};
            want[i] = careful_closest(&c, ray, &first);
            rk_triangles_closest(c.leaf, c.count, ray, &got);
            rk_check(same(&got, &want[i]), "leaf %u, ray %u: got triangle %u, carefully %u", key, i,
                     got.triangle, want[i].triangle);
            rk_check(rk_triangles_first_hit(c.leaf, c.count, ray) == first,
                     "leaf %u, ray %u: the first one that occludes is not %u", key, i, first);
            hits += want[i].triangle != RK_MISS;
        }
        check_wide(&c, want, key);
        pairs += (unsigned long long)c.count * ray_count;
    }
    printf("# %llu pairs of ray and triangle: float and double agree with double alone; %llu rays "
           "hit\n",
           pairs, hits);
    rk_check(hits > leaf_count() / 2, "%llu hits: too few", hits);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(float_rejects_only_what_the_careful_test_misses)};

RK_SUITE("stress triangle_filter", tests)
