/* Embree 3 or 4: its single rays, packets and streams, with and without its robust mode. Declared
 * in engine.h. https://github.com/RenderKit/embree documents the calls. */
#include "engine.h"

#include "base/table.h"

#if PEERS_EMBREE_VERSION >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#ifdef __SSE__
#include <xmmintrin.h>
#endif

#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { tree_low, tree_medium, tree_high, tree_robust, tree_count };

static const struct {
    const char *name;
    enum RTCBuildQuality quality;
    enum RTCSceneFlags flags;
} trees[tree_count] = {
    [tree_low] = {"low", RTC_BUILD_QUALITY_LOW, RTC_SCENE_FLAG_NONE},
    [tree_medium] = {"medium", RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_NONE},
    [tree_high] = {"high", RTC_BUILD_QUALITY_HIGH, RTC_SCENE_FLAG_NONE},
    [tree_robust] = {"medium-robust", RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_ROBUST},
};

/* Rays of a packet; coherent: Embree is told that they are. Embree 4 has no streams. */
static const struct {
    const char *name;
    uint32_t width;
    bool coherent, stream;
} ways[] = {
    {"single", 1, false, false},
    {"packet4-coherent", 4, true, false},
    {"packet4-incoherent", 4, false, false},
    {"packet8-coherent", 8, true, false},
    {"packet8-incoherent", 8, false, false},
    {"packet16-coherent", 16, true, false},
    {"packet16-incoherent", 16, false, false},
#if RTC_VERSION_MAJOR < 4
    {"stream-coherent", 1, true, true},
    {"stream-incoherent", 1, false, true},
#endif
};

enum { way_count = sizeof ways / sizeof *ways };

typedef struct embree {
    peers_engine base;
    uint32_t threads; /* of the device; 0: there is none yet */
    RTCDevice device;
    RTCScene scenes[tree_count];
    float *positions; /* with a float more than the mesh has: Embree reads four at a time */
    _Atomic ptrdiff_t bytes;
} embree;

/* --- Rays in Embree's form -------------------------------------------------------------------- */

/* RTCRayHit4, 8 and 16 are rows of 4, 8 and 16 numbers, and RTCRayHit of one each; occlusion rays
 * are the rows up to ray_rows. */
enum row {
    row_origin = 0,
    row_near = 3,
    row_direction = 4,
    row_time = 7,
    row_far = 8,
    row_mask = 9,
    row_id = 10,
    row_flags = 11,
    ray_rows = 12,
    row_normal = 12,
    row_u = 15,
    row_v = 16,
    row_primitive = 17,
    row_geometry = 18,
    row_instance = 19,
};

#define IS_ROW(member, row)                                                                        \
    _Static_assert(offsetof(struct RTCRayHit16, member) == 64 * (row) &&                           \
                       offsetof(struct RTCRayHit, member) == 4 * (row),                            \
                   #member " is row " #row)
IS_ROW(ray.org_x, row_origin);
IS_ROW(ray.tnear, row_near);
IS_ROW(ray.dir_x, row_direction);
IS_ROW(ray.time, row_time);
IS_ROW(ray.tfar, row_far);
IS_ROW(ray.mask, row_mask);
IS_ROW(ray.id, row_id);
IS_ROW(ray.flags, row_flags);
IS_ROW(hit.Ng_x, row_normal);
IS_ROW(hit.u, row_u);
IS_ROW(hit.v, row_v);
IS_ROW(hit.primID, row_primitive);
IS_ROW(hit.geomID, row_geometry);
IS_ROW(hit.instID, row_instance);

typedef union word {
    float f;
    uint32_t u;
} word;

enum { hit_words_max = sizeof(struct RTCRayHit) / sizeof(word) };

_Static_assert(sizeof(struct RTCRayHit4) <= 4 * sizeof(struct RTCRayHit) &&
                   sizeof(struct RTCRayHit8) <= 8 * sizeof(struct RTCRayHit) &&
                   sizeof(struct RTCRayHit16) <= 16 * sizeof(struct RTCRayHit),
               "packets need no more memory than as many single rays");

typedef struct lane {
    _Alignas(64) word words[PEERS_GROUP_RAYS * hit_words_max];
    _Alignas(64) int all[16], last[16]; /* which rays of a packet are valid */
    uint32_t count, packets, stride;    /* rays; packets; words of each */
    bool closest;
} lane;

static uint32_t words_of(uint32_t width, bool closest)
{
    const size_t bytes = width == 1   ? sizeof(struct RTCRayHit)
                         : width == 4 ? sizeof(struct RTCRayHit4)
                         : width == 8 ? sizeof(struct RTCRayHit8)
                                      : sizeof(struct RTCRayHit16);
    return closest ? (uint32_t)(bytes / sizeof(word)) : ray_rows * width;
}

static void put_ray(word *packet, uint32_t width, const rk_ray *ray, bool closest)
{
    const float floats[] = {ray->origin.x,    ray->origin.y,    ray->origin.z,    0,
                            ray->direction.x, ray->direction.y, ray->direction.z, 0,
                            ray->t_max};
    for (uint32_t row = 0; row <= row_far; row++)
        packet[row * width].f = floats[row];
    packet[row_mask * width].u = UINT32_MAX;
    packet[row_id * width].u = packet[row_flags * width].u = 0;
    if (closest)
        packet[row_primitive * width].u = packet[row_geometry * width].u =
            packet[row_instance * width].u = RTC_INVALID_GEOMETRY_ID;
}

static void load(const peers_engine *engine, peers_mode mode, void *at, const rk_ray_batch *rays,
                 uint32_t batches, bool closest)
{
    (void)engine;
    lane *self = at;
    const uint32_t width = ways[mode.way].width, stride = words_of(width, closest);
    uint32_t count = 0;
    for (uint32_t b = 0; b < batches; b++)
        for (uint32_t i = 0; i < rays[b].count; i++, count++) {
            const rk_ray ray = rk_batch_ray(&rays[b], i);
            put_ray(self->words + count / width * stride + count % width, width, &ray, closest);
        }
    self->count = count;
    self->packets = (count + width - 1) / width;
    /* Where packets of 16 are not native, Embree ignores which are valid: a ray that ends before
     * it begins is left out by all. */
    const rk_ray none = {.direction = {0, 0, 1}, .t_max = -1};
    for (; count < self->packets * width; count++)
        put_ray(self->words + count / width * stride + count % width, width, &none, closest);
    self->stride = stride;
    self->closest = closest;
    for (uint32_t i = 0; i < 16; i++) {
        self->all[i] = -1;
        self->last[i] = self->count % width == 0 || i < self->count % width ? -1 : 0;
    }
}

static void unload(const peers_engine *engine, peers_mode mode, const void *at, peers_hit *hits)
{
    (void)engine;
    const lane *self = at;
    const uint32_t width = ways[mode.way].width;
    for (uint32_t i = 0; i < self->count; i++) {
        const word *ray = self->words + i / width * self->stride + i % width;
        const float t = ray[row_far * width].f;
        if (!self->closest)
            hits[i] = (peers_hit){.triangle = t < 0 ? 0 : RK_MISS};
        else if (ray[row_geometry * width].u == RTC_INVALID_GEOMETRY_ID)
            hits[i] = (peers_hit){.triangle = RK_MISS};
        else
            hits[i] = (peers_hit){ray[row_primitive * width].u, t, ray[row_u * width].f,
                                  ray[row_v * width].f,
                                  rk_vec(ray[row_normal * width].f, ray[(row_normal + 1) * width].f,
                                         ray[(row_normal + 2) * width].f)};
    }
}

/* --- Tracing ---------------------------------------------------------------------------------- */

#if RTC_VERSION_MAJOR >= 4
typedef struct arguments {
    struct RTCIntersectArguments closest;
    struct RTCOccludedArguments any;
} arguments;

static arguments arguments_of(bool coherent)
{
    arguments a;
    rtcInitIntersectArguments(&a.closest);
    rtcInitOccludedArguments(&a.any);
    a.closest.flags = a.any.flags =
        coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    return a;
}

#define CLOSEST_1(ray) rtcIntersect1(scene, ray, &with.closest)
#define OCCLUDED_1(ray) rtcOccluded1(scene, ray, &with.any)
#define CLOSEST(width, valid, ray) rtcIntersect##width(valid, scene, ray, &with.closest)
#define OCCLUDED(width, valid, ray) rtcOccluded##width(valid, scene, ray, &with.any)
#else
typedef struct RTCIntersectContext arguments;

static arguments arguments_of(bool coherent)
{
    arguments a;
    rtcInitIntersectContext(&a);
    a.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return a;
}

#define CLOSEST_1(ray) rtcIntersect1(scene, &with, ray)
#define OCCLUDED_1(ray) rtcOccluded1(scene, &with, ray)
#define CLOSEST(width, valid, ray) rtcIntersect##width(valid, scene, &with, ray)
#define OCCLUDED(width, valid, ray) rtcOccluded##width(valid, scene, &with, ray)
#endif

static void trace_single(RTCScene scene, lane *self, arguments with)
{
    for (uint32_t i = 0; i < self->packets; i++) {
        void *ray = self->words + i * self->stride;
        if (self->closest)
            CLOSEST_1(ray);
        else
            OCCLUDED_1(ray);
    }
}

#define TRACE_PACKETS(width)                                                                       \
    static void trace_packets_##width(RTCScene scene, lane *self, arguments with)                  \
    {                                                                                              \
        for (uint32_t i = 0; i < self->packets; i++) {                                             \
            const int *valid = i + 1 < self->packets ? self->all : self->last;                     \
            void *packet = self->words + i * self->stride;                                         \
            if (self->closest)                                                                     \
                CLOSEST(width, valid, packet);                                                     \
            else                                                                                   \
                OCCLUDED(width, valid, packet);                                                    \
        }                                                                                          \
    }
TRACE_PACKETS(4)
TRACE_PACKETS(8)
TRACE_PACKETS(16)

static void trace_stream(RTCScene scene, lane *self, arguments with)
{
#if RTC_VERSION_MAJOR < 4
    const size_t bytes = self->stride * sizeof(word);
    for (uint32_t first = 0; first < self->count; first += RK_BATCH_MAX) {
        void *rays = self->words + first * self->stride;
        const uint32_t left = self->count - first,
                       count = left < RK_BATCH_MAX ? left : RK_BATCH_MAX;
        if (self->closest)
            rtcIntersect1M(scene, &with, rays, count, bytes);
        else
            rtcOccluded1M(scene, &with, rays, count, bytes);
    }
#else
    trace_single(scene, self, with);
#endif
}

/* Embree's manual recommends to treat denormal numbers as 0. Returns the old setting. */
static unsigned ignore_denormals(void)
{
#ifdef __SSE__
    const unsigned before = _mm_getcsr(), flush_to_zero = 1u << 15, denormals_are_zero = 1u << 6;
    _mm_setcsr(before | flush_to_zero | denormals_are_zero);
    return before;
#else
    return 0;
#endif
}

static void heed_denormals(unsigned before)
{
#ifdef __SSE__
    _mm_setcsr(before);
#else
    (void)before;
#endif
}

static void trace(const peers_engine *engine, peers_mode mode, void *at)
{
    const unsigned before = ignore_denormals();
    RTCScene scene = ((const embree *)engine)->scenes[mode.tree];
    const arguments with = arguments_of(ways[mode.way].coherent);
    if (ways[mode.way].stream)
        trace_stream(scene, at, with);
    else if (ways[mode.way].width == 1)
        trace_single(scene, at, with);
    else if (ways[mode.way].width == 4)
        trace_packets_4(scene, at, with);
    else if (ways[mode.way].width == 8)
        trace_packets_8(scene, at, with);
    else
        trace_packets_16(scene, at, with);
    heed_denormals(before);
}

/* --- Trees ------------------------------------------------------------------------------------ */

static peers_name tree_name(const peers_engine *engine, uint32_t tree)
{
    (void)engine;
    peers_name name;
    snprintf(name.text, sizeof name.text, "%s", trees[tree].name);
    return name;
}

static peers_name mode_name(const peers_engine *engine, peers_mode mode)
{
    (void)engine;
    peers_name name;
    snprintf(name.text, sizeof name.text, "%s%s", ways[mode.way].name,
             mode.tree == tree_robust ? "-robust" : "");
    return name;
}

/* Embree tells of what it allocates and, in negative numbers, of what it frees. */
static bool count_bytes(void *context, ssize_t bytes, bool post)
{
    (void)post;
    atomic_fetch_add(&((embree *)context)->bytes, bytes);
    return true;
}

static void release_trees(embree *self)
{
    for (uint32_t tree = 0; tree < tree_count; tree++) {
        if (self->scenes[tree])
            rtcReleaseScene(self->scenes[tree]);
        self->scenes[tree] = NULL;
    }
}

/* Embree takes the most threads of all devices that there are, so there is one at a time. */
static bool open_device(embree *self, uint32_t threads, rk_error *error)
{
    if (self->threads == threads)
        return true;
    char settings[64];
    snprintf(settings, sizeof settings, "threads=%u,start_threads=1,set_affinity=0", threads);
    release_trees(self);
    if (self->device)
        rtcReleaseDevice(self->device);
    self->device = rtcNewDevice(settings);
    self->threads = self->device ? threads : 0;
    if (!self->device)
        return rk_fail(error,
                       "Embree does not start on this processor (its error %d): it needs "
                       "SSE2 or NEON",
                       (int)rtcGetDeviceError(NULL));
    rtcSetDeviceMemoryMonitorFunction(self->device, count_bytes, self);
    return true;
}

static bool build(peers_engine *engine, uint32_t tree, uint32_t threads, double *seconds,
                  double *bytes, rk_error *error)
{
    embree *self = (embree *)engine;
    const rk_mesh *mesh = &engine->scene->mesh;
    if (!open_device(self, threads, error))
        return false;
    if (self->scenes[tree])
        rtcReleaseScene(self->scenes[tree]);
    const ptrdiff_t before = atomic_load(&self->bytes);
    const double start = rk_clock_wall();
    RTCScene scene = self->scenes[tree] = rtcNewScene(self->device);
    RTCGeometry geometry = rtcNewGeometry(self->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSceneFlags(scene, trees[tree].flags);
    rtcSetSceneBuildQuality(scene, trees[tree].quality);
    rtcSetGeometryBuildQuality(geometry, trees[tree].quality);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               self->positions, 0, 3 * sizeof(float), mesh->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh->triangles, 0, sizeof *mesh->triangles, mesh->triangle_count);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    *seconds = rk_clock_wall() - start;
    *bytes = (double)(atomic_load(&self->bytes) - before);
    const enum RTCError failed = rtcGetDeviceError(self->device);
    return failed == RTC_ERROR_NONE ||
           rk_fail(error, "%s: Embree could not build its tree (its error %d)", engine->scene->name,
                   (int)failed);
}

/* --- The engine ------------------------------------------------------------------------------- */

static void close_embree(peers_engine *engine)
{
    embree *self = (embree *)engine;
    if (!self)
        return;
    release_trees(self);
    if (self->device)
        rtcReleaseDevice(self->device);
    free(self->positions);
    free(self);
}

peers_engine *peers_embree_open(const rk_scene *scene, rk_error *error)
{
    embree *self = rk_allocate(1, sizeof *self, "Embree", error);
    if (!self)
        return NULL;
    self->base = (peers_engine){.name = "embree",
                                .scene = scene,
                                .lane_bytes = sizeof(lane),
                                .tree_count = tree_count,
                                .tree_name = tree_name,
                                .build = build,
                                .mode_name = mode_name,
                                .load = load,
                                .trace = trace,
                                .unload = unload,
                                .close = close_embree};
    for (uint32_t robust = 0; robust < 2; robust++)
        for (uint32_t way = 0; way < way_count; way++)
            self->base.modes[self->base.mode_count++] =
                (peers_mode){robust ? tree_robust : tree_medium, way};
    const size_t floats = 3 * (size_t)scene->mesh.vertex_count;
    self->positions = rk_allocate(floats + 1, sizeof *self->positions, "positions", error);
    if (!self->positions) {
        close_embree(&self->base);
        return NULL;
    }
    memcpy(self->positions, scene->mesh.positions, floats * sizeof *self->positions);
    return &self->base;
}

peers_name peers_embree_version(void)
{
    peers_name name;
    snprintf(name.text, sizeof name.text, "Embree %s", RTC_VERSION_STRING);
    return name;
}
