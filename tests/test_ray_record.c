/* The record of a pixel's rays, which views draw: over all pixels it adds up to the rays that the
 * picture's counters count, whichever features make them, leave them out, or trace them. */
#include "test_scene.h"

#include "render/ray_record.h"
#include "scenes/sky.h"

typedef struct totals {
    uint64_t camera, reflected, shadow, unoccluded, crossings;
} totals;

static void add(totals *sum, const rk_ray_record_entry *ray)
{
    sum->camera += ray->kind == RK_RAY_CAMERA;
    sum->reflected += ray->kind == RK_RAY_REFLECTED;
    sum->shadow += ray->kind == RK_RAY_SHADOW;
    sum->unoccluded += ray->kind == RK_RAY_SHADOW && !ray->occluded;
    sum->crossings += ray->crossing_count;
    rk_check((ray->bounce == 0) == (ray->kind == RK_RAY_CAMERA) || ray->kind == RK_RAY_SHADOW,
             "a ray of kind %d after %u reflections", (int)ray->kind, ray->bounce);
}

/* By the tree that drivers use unless asked otherwise. */
typedef struct recorder {
    rk_accel accel;
    rk_pool *pool;
    const rk_scene *scene;
} recorder;

static recorder recorder_of(const rk_scene *scene)
{
    recorder w = {.scene = scene};
    rk_error error;
    w.pool = rk_pool_start(2, &error);
    rk_check_ok(w.pool != NULL, error);
    rk_check_ok(rk_accel_build(&w.accel, RK_ACCEL_MEDIAN, scene, &error), error);
    return w;
}

static void recorder_free(recorder *w)
{
    rk_accel_free(&w->accel);
    rk_pool_stop(w->pool);
}

static rk_ray_record record_of(const recorder *w, const rk_render_options *options, uint32_t pixel)
{
    rk_ray_record record = {.pixel = pixel};
    rk_error error;
    rk_check_ok(rk_ray_record_pixel(&record, w->scene, &w->accel, options, w->pool, &error), error);
    return record;
}

static totals recorded(const rk_scene *scene, const rk_render_options *options)
{
    recorder w = recorder_of(scene);
    totals sum = {0};
    for (uint32_t pixel = 0; pixel < options->width * options->height; pixel++) {
        const uint64_t before = sum.crossings;
        rk_ray_record record = record_of(&w, options, pixel);
        for (size_t i = 0; i < record.count; i++)
            add(&sum, &record.rays[i]);
        rk_check_equal(sum.crossings - before, record.crossing_count, "each crossing has its ray");
        rk_ray_record_free(&record);
    }
    recorder_free(&w);
    return sum;
}

/* `before`: camera rays of the picture that look at it before any sample. Returns the sums. */
static totals check_sums(const rk_scene *scene, rk_render_options options, uint64_t before,
                         const char *what)
{
    const totals sum = recorded(scene, &options);
    test_picture picture = test_render(scene, options, 1);
    const rk_counters *counters = &picture.counters;
    rk_check_equal(sum.camera + before, counters->primary_rays, what);
    rk_check_equal(sum.reflected, counters->reflected_rays, what);
    rk_check_equal(sum.shadow, counters->shadow_rays, what);
    rk_check_equal(sum.crossings, counters->crossings, what);
    rk_image_free(&picture.image);
    return sum;
}

/* Two tiles across, so that a pixel's tile is not always the first. */
static rk_render_options small(void)
{
    rk_render_options options = rk_render_options_default();
    options.width = 18;
    options.height = 5;
    options.shadows = true;
    options.light.samples = 9;
    return options;
}

static void shadow_rays_are_those_that_the_renderer_traces(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = small();
    options.light.samples = 64;
    options.light.visibility = RK_LIGHT_RAYS;
    const totals all = check_sums(&scene, options, 0, "all shadow rays");
    options.light.visibility = RK_LIGHT_PYRAMIDS;
    const totals pyramids = check_sums(&scene, options, 0, "not where the pyramid is empty");
    options.light.early_out = 8;
    const totals early = check_sums(&scene, options, 0, "after an early out, few");
    rk_check(all.shadow > pyramids.shadow && pyramids.shadow > early.shadow,
             "%llu, %llu and %llu shadow rays: these settings leave rays out",
             (unsigned long long)all.shadow, (unsigned long long)pyramids.shadow,
             (unsigned long long)early.shadow);
    rk_check(all.unoccluded > 0 && all.unoccluded < all.shadow, "some shadow rays are occluded");
    options.shadows = false;
    rk_check_equal(check_sums(&scene, options, 0, "without --shadows").shadow, 0, "none");
    rk_scene_free(&scene);
}

static void samples_of_pixels_and_adaptive_ones_are_recorded(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = small();
    options.samples = 3;
    check_sums(&scene, options, 0, "three samples");
    options.ambient_occlusion.intensity = 1;
    options.ambient_occlusion.samples = 5;
    check_sums(&scene, options, 0, "ambient rays, too");
    options.width = options.height = 6; /* each record renders the whole picture */
    options.adaptive_sampling.error = 0.2f;
    check_sums(&scene, options, 0, "adaptive sampling");
    rk_scene_free(&scene);
}

static void reflected_rays_are_recorded_by_their_bounce(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = small();
    options.reflections = true;
    check_sums(&scene, options, 0, "mirrors");
    options.glossy.samples = 4;
    const totals sum = check_sums(&scene, options, 0, "rough mirrors");
    rk_check(sum.reflected > 0, "the scene has a mirror");
    options.max_depth = 0;
    rk_check_equal(check_sums(&scene, options, 0, "--max-depth 0").reflected, 0, "none");
    rk_scene_free(&scene);
}

static void transparent_surfaces_and_their_shadows_are_recorded(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-glass");
    rk_render_options options = small();
    options.transparency = true;
    const totals all = check_sums(&scene, options, 0, "glass");
    options.max_depth = 1;
    const totals one = check_sums(&scene, options, 0, "glass, one surface passed");
    rk_check(one.crossings < all.crossings,
             "fewer surfaces are passed than some rays have in their way");
    options.transparency = false;
    rk_check_equal(check_sums(&scene, options, 0, "opaque").crossings, 0, "all is opaque");
    rk_scene_free(&scene);
}

/* Centre rays look at each pixel before, and at none beyond the border: nothing there is near. */
static void rays_from_a_lens_are_those_of_pixels_out_of_focus(void **state)
{
    (void)state;
    for (int sky = 0; sky < 2; sky++) {
        rk_scene scene = test_scene_builtin("cube");
        rk_render_options options = small();
        rk_error error;
        if (sky)
            rk_check_ok(rk_sky_make(&scene.environment, 8, &error), error);
        options.lens_samples = 6;
        options.lens = (rk_lens){.focal_distance = 1.8f, .aperture = 600, .focal = RK_FOCAL_PLANE};
        test_picture picture = test_render(&scene, options, 1);
        const totals sum = recorded(&scene, &options);
        const uint64_t pixels = options.width * options.height;
        const uint64_t blurred = picture.counters.lens_samples / options.lens_samples;
        rk_check_equal(sum.camera, pixels - blurred + blurred * options.lens_samples,
                       sky ? "with a sky" : "before black");
        rk_check(blurred > 0 && (sky || blurred < pixels), "%llu of %llu pixels are blurred",
                 (unsigned long long)blurred, (unsigned long long)pixels);
        rk_image_free(&picture.image);
        rk_scene_free(&scene);
    }
}

static void a_pixel_in_focus_can_be_recorded_as_if_it_were_not(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cube");
    rk_render_options options = small();
    options.lens_samples = 6;
    options.lens = (rk_lens){.focal_distance = 1.8f, .aperture = 1, .focal = RK_FOCAL_PLANE};
    recorder w = recorder_of(&scene);
    rk_ray_record in_focus = record_of(&w, &options, 0);
    rk_ray_record through_lens = {.pixel = 0, .through_lens = true};
    rk_error error;
    rk_check_ok(rk_ray_record_pixel(&through_lens, &scene, &w.accel, &options, w.pool, &error),
                error);
    rk_check_equal(rk_ray_record_count(&in_focus, RK_RAY_CAMERA, 0), 1, "without lens samples");
    rk_check_equal(rk_ray_record_count(&through_lens, RK_RAY_CAMERA, 0), 6, "one for each");
    rk_ray_record_free(&in_focus);
    rk_ray_record_free(&through_lens);
    recorder_free(&w);
    rk_scene_free(&scene);
}

static void a_record_of_a_moving_scene_has_its_rays(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("moving");
    rk_render_options options = small();
    options.motion.samples = 4;
    check_sums(&scene, options, 0, "in motion");
    rk_scene_free(&scene);
}

static void a_hit_of_the_record_is_what_the_pixel_sees(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = small();
    options.height = 35; /* three tiles down */
    recorder w = recorder_of(&scene);
    const uint32_t x = 17, y = 33;
    rk_ray_record record = record_of(&w, &options, y * options.width + x);
    const rk_view view = rk_view_of(&scene.camera, options.width, options.height);
    const rk_ray centre = rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f);
    rk_check(record.count > 0 && record.rays[0].kind == RK_RAY_CAMERA,
             "the camera ray comes first");
    rk_check(memcmp(&record.rays[0].ray.direction, &centre.direction, sizeof centre.direction) == 0,
             "one sample passes through the pixel's centre");
    rk_check(record.rays[0].hit.triangle != RK_MISS && record.rays[0].hit.t > 0,
             "the wall of the box is hit");
    rk_ray_record_free(&record);
    recorder_free(&w);
    rk_scene_free(&scene);
}

static void options_that_the_renderer_refuses_record_nothing(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = small();
    recorder w = recorder_of(&scene);
    rk_ray_record record = {.pixel = 0};
    rk_error error = {""};
    options.samples = 0;
    rk_check(!rk_ray_record_pixel(&record, &scene, &w.accel, &options, w.pool, &error) &&
                 *error.text,
             "no samples, but no error");
    rk_check_equal(record.count, 0, "nothing was traced");
    rk_ray_record_free(&record);
    recorder_free(&w);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(shadow_rays_are_those_that_the_renderer_traces),
    cmocka_unit_test(samples_of_pixels_and_adaptive_ones_are_recorded),
    cmocka_unit_test(reflected_rays_are_recorded_by_their_bounce),
    cmocka_unit_test(transparent_surfaces_and_their_shadows_are_recorded),
    cmocka_unit_test(rays_from_a_lens_are_those_of_pixels_out_of_focus),
    cmocka_unit_test(a_pixel_in_focus_can_be_recorded_as_if_it_were_not),
    cmocka_unit_test(a_record_of_a_moving_scene_has_its_rays),
    cmocka_unit_test(a_hit_of_the_record_is_what_the_pixel_sees),
    cmocka_unit_test(options_that_the_renderer_refuses_record_nothing),
};

RK_SUITE("ray_record", tests)
