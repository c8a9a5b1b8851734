/* Scenes as JSON: numbers come back to the bit, and a scene that needs more is refused. The file as
 * a whole is read by tests/test_compare.py. */
#include "test.h"

#include "driver/compared_scene.h"
#include "driver/scene_json.h"
#include "scenes/builtin.h"
#include "test_folder.h"

static rk_compared_scene make(rk_compared_kind kind)
{
    rk_compared_scene c;
    rk_error error;
    rk_check_ok(rk_compared_scene_init(&c, kind, 16, 4, &error), error);
    return c;
}

/* The file as a text to free(). */
static char *written(const test_folder *folder, const rk_compared_scene *c)
{
    rk_error error;
    const test_path path = test_folder_path(folder, "scene.json");
    rk_check_ok(rk_scene_json_write(path.text, &c->scene, &c->options, &error), error);
    size_t size;
    char *text = (char *)test_folder_read(path, &size);
    text[size] = '\0';
    return text;
}

static void vertices_come_back_to_the_bit(void **state)
{
    rk_compared_scene c = make(RK_COMPARED_MOTION);
    char *text = written(*state, &c), *at = text;
    const rk_mesh *mesh = &c.scene.mesh;
    for (uint32_t i = 0; i < 3 * mesh->triangle_count; i++) {
        if (i == 0 || i == 3 * c.scene.moving[0].first)
            at = strstr(at, "\"vertices\": [") + strlen("\"vertices\": [");
        const rk_vec3 want = mesh->positions[mesh->triangles[i / 3][i % 3]];
        for (int axis = 0; axis < 3; axis++) {
            at += strcspn(at, "-0123456789");
            rk_check_near(strtof(at, &at), rk_axis(want, axis), 0, "corner %u, axis %d", i, axis);
        }
    }
    free(text);
    rk_compared_scene_free(&c);
}

static void what_is_absent_is_null(void **state)
{
    const struct {
        rk_compared_kind kind;
        const char *lens, *shutter;
    } cases[] = {
        {RK_COMPARED_CORNELL, "\"lens\": null", "\"shutter\": null"},
        {RK_COMPARED_LENS, "\"focal_distance\": 2.5, \"diameter\": 0.15", "\"shutter\": null"},
        {RK_COMPARED_MOTION, "\"lens\": null", "\"open\": 0, \"close\": 0.15"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        rk_compared_scene c = make(cases[i].kind);
        char *text = written(*state, &c);
        rk_check(strstr(text, cases[i].lens), "%s should have %s", c.scene.name, cases[i].lens);
        rk_check(strstr(text, cases[i].shutter), "%s should have %s", c.scene.name,
                 cases[i].shutter);
        free(text);
        rk_compared_scene_free(&c);
    }
}

static void an_object_at_rest_belongs_to_the_others(void **state)
{
    rk_compared_scene c = make(RK_COMPARED_MOTION);
    c.options.motion.samples = 0;
    char *text = written(*state, &c);
    rk_check(strstr(text, "\"shutter\": null"), "with no times, nothing moves");
    char *first = strstr(text, "\"vertices\"");
    rk_check(first && !strstr(first + 1, "\"vertices\""), "there should be one object");
    free(text);
    rk_compared_scene_free(&c);
}

/* Changes to the Cornell box, and a word of the message. */
static void with_a_sphere(rk_compared_scene *c)
{
    c->scene.sphere_count = 1;
}
static void with_a_mirror(rk_compared_scene *c)
{
    c->scene.mesh.materials[1].ks.y = 0.5f;
}
static void with_glass(rk_compared_scene *c)
{
    c->scene.mesh.materials[1].alpha = 0.5f;
}
static void with_a_point_light(rk_compared_scene *c)
{
    c->scene.lights[0].kind = RK_LIGHT_POINT;
}
static void with_colours(rk_compared_scene *c)
{
    c->scene.lights[0].colours[2].x = 0;
}
static void not_normalized(rk_compared_scene *c)
{
    c->options.shading.normalized = false;
}
static void with_highlights(rk_compared_scene *c)
{
    c->options.shading.model = RK_SHADING_PHONG;
}
static void without_falloff(rk_compared_scene *c)
{
    c->options.light.falloff = RK_FALLOFF_NONE;
}
static void without_shadows(rk_compared_scene *c)
{
    c->options.shadows = false;
}
static void on_a_sphere(rk_compared_scene *c)
{
    c->options.lens.focal = RK_FOCAL_SPHERE;
}

static void scenes_that_need_more_are_refused(void **state)
{
    const struct {
        void (*change)(rk_compared_scene *c);
        const char *word;
    } cases[] = {
        {with_a_sphere, "spheres"},   {with_a_mirror, "mirrors"},
        {with_glass, "glass"},        {with_a_point_light, "lights"},
        {with_colours, "one colour"}, {not_normalized, "normalized"},
        {with_highlights, "shading"}, {without_falloff, "falloff"},
        {without_shadows, "shadows"}, {on_a_sphere, "focal sphere"},
    };
    const test_path path = test_folder_path(*state, "scene.json");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        rk_compared_scene c = make(RK_COMPARED_LENS);
        rk_error error = {""};
        cases[i].change(&c);
        rk_check(!rk_scene_json_write(path.text, &c.scene, &c.options, &error),
                 "it should be refused: %s", cases[i].word);
        rk_check_error_names(error, cases[i].word);
        rk_compared_scene_free(&c);
    }
    rk_check(test_folder_count(*state) == 0, "nothing should be written");
}

static void smooth_normals_are_refused(void **state)
{
    rk_error error = {""};
    rk_compared_scene c = make(RK_COMPARED_CORNELL);
    rk_scene teapot;
    rk_check_ok(rk_builtin_scene(&teapot, "teapot", &error), error);
    teapot.light_count = 0;
    const test_path path = test_folder_path(*state, "scene.json");
    rk_check(!rk_scene_json_write(path.text, &teapot, &c.options, &error), "it has normals");
    rk_check_error_names(error, "smooth normals");
    rk_scene_free(&teapot);
    rk_compared_scene_free(&c);
}

static const struct CMUnitTest tests[] = {
    test_in_folder(vertices_come_back_to_the_bit),
    test_in_folder(what_is_absent_is_null),
    test_in_folder(an_object_at_rest_belongs_to_the_others),
    test_in_folder(scenes_that_need_more_are_refused),
    test_in_folder(smooth_normals_are_refused),
};

RK_SUITE("scene_json", tests)
