/* Framing of scene/framing.h. A perspective picture's four sides are planes through the camera.
 * With r, u and f a point's places to the right, up and along the view, and k the slope of a side,
 * a mesh scaled by s and moved by -c is inside the right and the left side if s r - c <= k (d + s
 * f)  and  c - s r <= k (d + s f)  for all points, d the distance of the camera. So only max (r - k
 * f) and min (r + k f) count, and the largest s follows from the sum of both. */
#include "scene/framing.h"

#include <assert.h>
#include <float.h>
#include <stdlib.h>

/* Of the picture's width or height. */
static const double filled = 2.0 / 3;
/* Where so many of the triangles lie in so much of the extent, the others are strays. */
static const double most_triangles = 0.9, small_extent = 0.1;
/* Triangles by which the place of most is found; strays are few among them, too. */
enum { SAMPLES = 1 << 13 };

rk_framing rk_framing_default(void)
{
    return (rk_framing){RK_UP_OF_FILE, RK_FRONT_USUAL, rk_camera_default().rotation, 1, 1};
}

/* --- Turning --------------------------------------------------------------------------------- */

static rk_front front_of(rk_up up, rk_front front)
{
    const rk_front usual = up == RK_UP_Z ? RK_FRONT_MINUS_Y : RK_FRONT_Z;
    return front == RK_FRONT_USUAL ? usual : front;
}

/* The axis, without its sign: 0 is x. */
static int axis_of(rk_front front)
{
    return ((int)front - RK_FRONT_X) % 3;
}

bool rk_front_is_up(rk_front front, rk_up up)
{
    return axis_of(front_of(up, front)) == (int)up;
}

static rk_vec3 unit_vector(int axis)
{
    return rk_vec(axis == 0, axis == 1, axis == 2);
}

static rk_vec3 in_axes(rk_vec3 p, rk_vec3 x, rk_vec3 y, rk_vec3 z)
{
    return rk_vec(rk_dot(p, x), rk_dot(p, y), rk_dot(p, z));
}

void rk_mesh_face_viewer(rk_mesh *mesh, rk_up up, rk_front front)
{
    assert(!rk_front_is_up(front, up) && "up and front are two axes");
    front = front_of(up, front);
    const float sign = front >= RK_FRONT_MINUS_X ? -1 : 1;
    const rk_vec3 top = unit_vector((int)up), back = rk_scale(unit_vector(axis_of(front)), -sign);
    const rk_vec3 left = rk_cross(top, back);
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        mesh->positions[i] = in_axes(mesh->positions[i], left, top, back);
    for (uint32_t i = 0; mesh->normals && i < mesh->vertex_count; i++)
        mesh->normals[i] = in_axes(mesh->normals[i], left, top, back);
}

/* --- Strays ---------------------------------------------------------------------------------- */

static rk_box triangle_box(const rk_mesh *mesh, uint32_t triangle)
{
    rk_box box = rk_box_empty();
    for (int k = 0; k < 3; k++)
        box = rk_box_add(box, mesh->positions[mesh->triangles[triangle][k]]);
    return box;
}

static bool is_inside(rk_box inner, rk_box outer)
{
    const rk_vec3 *in = inner.corner, *out = outer.corner;
    return in[0].x >= out[0].x && in[0].y >= out[0].y && in[0].z >= out[0].z &&
           in[1].x <= out[1].x && in[1].y <= out[1].y && in[1].z <= out[1].z;
}

/* The bounds of the triangles inside a box, and their number. */
static rk_box bounds_within(const rk_mesh *mesh, rk_box within, uint32_t *count)
{
    rk_box bounds = rk_box_empty();
    *count = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        rk_box box = triangle_box(mesh, i);
        if (!is_inside(box, within))
            continue;
        bounds = rk_box_merge(bounds, box);
        ++*count;
    }
    return bounds;
}

static double component(rk_vec3 v, int axis)
{
    return (double)(axis == 0 ? v.x : axis == 1 ? v.y : v.z);
}

static double side(rk_box box, int axis)
{
    return component(box.corner[1], axis) - component(box.corner[0], axis);
}

static double longest_side(rk_box box)
{
    return fmax(side(box, 0), fmax(side(box, 1), side(box, 2)));
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The shortest interval that holds most of the values. */
static void shortest_interval(double *values, uint32_t count, double interval[2])
{
    const uint32_t most = (uint32_t)ceil(most_triangles * count);
    qsort(values, count, sizeof *values, by_value);
    interval[0] = values[0], interval[1] = values[most - 1];
    for (uint32_t i = 1; i + most <= count; i++)
        if (values[i + most - 1] - values[i] < interval[1] - interval[0])
            interval[0] = values[i], interval[1] = values[i + most - 1];
}

/* Where most triangles' middles are, along each axis; returns its longest side. */
static double place_of_most(const rk_mesh *mesh, double place[3][2], double *values)
{
    const uint32_t all = mesh->triangle_count, count = all < SAMPLES ? all : SAMPLES;
    double longest = 0;
    for (int axis = 0; axis < 3; axis++) {
        for (uint32_t i = 0; i < count; i++) {
            rk_box box = triangle_box(mesh, (uint32_t)((uint64_t)i * all / count));
            values[i] = 0.5 * (component(box.corner[0], axis) + component(box.corner[1], axis));
        }
        shortest_interval(values, count, place[axis]);
        longest = fmax(longest, place[axis][1] - place[axis][0]);
    }
    return longest;
}

/* The box in which triangles are framed: `all`, or without strays. */
static rk_box frame_of(const rk_mesh *mesh, rk_box all, rk_framed *framed, double *values)
{
    double place[3][2];
    const double longest = place_of_most(mesh, place, values);
    *framed = (rk_framed){mesh->triangle_count, 1};
    if (longest > small_extent * longest_side(all))
        return all;
    float low[3], high[3];
    for (int axis = 0; axis < 3;
         axis++) { /* as much again on both sides: an interval cuts its ends off */
        low[axis] = (float)fmax(place[axis][0] - longest, -(double)FLT_MAX);
        high[axis] = (float)fmin(place[axis][1] + longest, (double)FLT_MAX);
    }
    uint32_t count;
    rk_box most = bounds_within(
        mesh, (rk_box){{rk_vec(low[0], low[1], low[2]), rk_vec(high[0], high[1], high[2])}},
        &count);
    const double extent = longest_side(most) / longest_side(all);
    if (!(count >= most_triangles * mesh->triangle_count && extent > 0 && extent <= small_extent))
        return all;
    *framed = (rk_framed){count, extent};
    return most;
}

/* --- Framing --------------------------------------------------------------------------------- */

typedef struct frame {
    double
        centre[3]; /* of the framed bounds: places are relative to it, which keeps their digits */
    double axes[3][3];            /* right, up, along the view */
    double slope[2];              /* of the picture's sides, right and up */
    double least[2], greatest[2]; /* min (r + k f) and max (r - k f), for right and up */
    double near, far;             /* least and largest f */
} frame;

static frame frame_begin(const rk_view *view, rk_box bounds)
{
    const rk_vec3 axes[3] = {view->right, view->up, view->forward};
    frame f = {.slope = {filled * (double)view->half_width, filled * (double)view->half_height},
               .least = {INFINITY, INFINITY},
               .greatest = {-INFINITY, -INFINITY},
               .near = INFINITY,
               .far = -INFINITY};
    for (int k = 0; k < 3; k++) {
        f.centre[k] = 0.5 * (component(bounds.corner[0], k) + component(bounds.corner[1], k));
        for (int axis = 0; axis < 3; axis++)
            f.axes[k][axis] = component(axes[k], axis);
    }
    return f;
}

static void frame_add(frame *f, rk_vec3 point)
{
    const double p[3] = {(double)point.x - f->centre[0], (double)point.y - f->centre[1],
                         (double)point.z - f->centre[2]};
    double place[3];
    for (int k = 0; k < 3; k++)
        place[k] = p[0] * f->axes[k][0] + p[1] * f->axes[k][1] + p[2] * f->axes[k][2];
    for (int k = 0; k < 2; k++) {
        f->least[k] = fmin(f->least[k], place[k] + f->slope[k] * place[2]);
        f->greatest[k] = fmax(f->greatest[k], place[k] - f->slope[k] * place[2]);
    }
    f->near = fmin(f->near, place[2]);
    f->far = fmax(f->far, place[2]);
}

/* Fills in what p / scale is moved by. Returns the scale. */
static double frame_end(frame *f, double distance, double shift[3])
{
    const double middle = 0.5 * (f->near + f->far);
    double scale = distance / (f->far - f->near), centre[3] = {0, 0, middle};
    for (int k = 0; k < 2; k++) {
        const double least = f->least[k] - f->slope[k] * middle,
                     greatest = f->greatest[k] + f->slope[k] * middle;
        scale = fmin(scale, 2 * distance * f->slope[k] / (greatest - least));
        centre[k] = 0.5 * (least + greatest);
    }
    for (int axis = 0; axis < 3; axis++) {
        shift[axis] = f->centre[axis];
        for (int k = 0; k < 3; k++)
            shift[axis] += centre[k] * f->axes[k][axis];
    }
    return isfinite(scale) ? scale : 1;
}

static void move(rk_mesh *mesh, const double shift[3], double scale, rk_vec3 target)
{
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        rk_vec3 *p = &mesh->positions[i];
        *p = rk_vec((float)(((double)p->x - shift[0]) * scale + (double)target.x),
                    (float)(((double)p->y - shift[1]) * scale + (double)target.y),
                    (float)(((double)p->z - shift[2]) * scale + (double)target.z));
    }
}

bool rk_mesh_frame(rk_mesh *mesh, const rk_camera *camera, size_t width, size_t height,
                   rk_framed *framed, rk_error *error)
{
    *framed = (rk_framed){mesh->triangle_count, 1};
    if (mesh->triangle_count == 0)
        return true;
    double *values = rk_allocate(SAMPLES, sizeof *values, "places of triangles", error);
    if (!values)
        return false;
    uint32_t count;
    const float most = FLT_MAX;
    const rk_box all = bounds_within(
        mesh, (rk_box){{rk_vec(-most, -most, -most), rk_vec(most, most, most)}}, &count);
    const rk_box within = frame_of(mesh, all, framed, values);
    free(values);
    const rk_view view = rk_view_of(camera, width, height);
    frame f = frame_begin(&view, within);
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        if (framed->triangles == mesh->triangle_count || is_inside(triangle_box(mesh, i), within))
            for (int k = 0; k < 3; k++)
                frame_add(&f, mesh->positions[mesh->triangles[i][k]]);
    double shift[3];
    const double scale = frame_end(&f, (double)camera->distance, shift);
    move(mesh, shift, scale, camera->look_at);
    return true;
}

/* --- The scene ------------------------------------------------------------------------------- */

/* The default light, at the place that it has in the default camera's view. */
static void light_with_camera(rk_scene *scene)
{
    const rk_camera usual = rk_camera_default();
    const rk_view from = rk_view_of(&usual, 1, 1), to = rk_view_of(&scene->camera, 1, 1);
    rk_scene_default_light(scene);
    const rk_vec3 light = scene->lights[0].position;
    rk_vec3 turned = rk_scale(to.right, rk_dot(light, from.right));
    turned = rk_madd(turned, to.up, rk_dot(light, from.up));
    scene->lights[0] =
        rk_light_point(rk_madd(turned, to.forward, rk_dot(light, from.forward)), rk_vec(1, 1, 1));
}

static rk_up up_of(const rk_mesh *mesh, rk_up up)
{
    if (up != RK_UP_OF_FILE)
        return up;
    return mesh->up == 0 ? RK_UP_Y : (rk_up)(mesh->up - 1);
}

bool rk_scene_framed(rk_scene *scene, const char *name, rk_mesh *mesh, const rk_framing *framing,
                     rk_framed *framed, rk_error *error)
{
    rk_scene_init(scene, name, mesh);
    scene->camera.rotation = framing->rotation;
    const rk_up up = up_of(&scene->mesh, (rk_up)framing->up);
    const rk_front front = (rk_front)framing->front;
    bool ok = rk_mesh_validate(&scene->mesh, name, error);
    if (ok && rk_front_is_up(front, up))
        ok = rk_fail(error,
                     "%s: the front that you chose is the axis that points up: choose another one, "
                     "or another one for up",
                     name);
    if (ok) {
        rk_mesh_face_viewer(&scene->mesh, up, front);
        ok = rk_mesh_frame(&scene->mesh, &scene->camera, framing->width, framing->height, framed,
                           error);
    }
    if (!ok) {
        rk_scene_free(scene);
        return false;
    }
    light_with_camera(scene);
    return true;
}
