/* The lens: its disk, rays that converge in focus, circles of confusion against the closed form and
 * against the rays themselves, and the pixels that they reach. */
#include "test.h"

#include "base/dvec3.h"
#include "base/random.h"
#include "base/table.h"
#include "features/depth_of_field.h"
#include "features/glossy_reflection.h"

static const double epsilon = 0x1p-24; /* half an ulp of 1: one rounding to float */

static float unit_float(uint32_t i, uint32_t which)
{
    return rk_unit_float(rk_case(i, which, 0, 9));
}

/* A camera that is rotated about all axes, differently for each i. */
static rk_view turned_view(uint32_t i)
{
    rk_camera camera = {
        .look_at = rk_vec(0.5f, -1, 2),
        .distance = 3,
        .rotation = rk_vec(360 * unit_float(i, 0), 360 * unit_float(i, 1), 360 * unit_float(i, 2)),
        .fov = 50};
    return rk_view_of(&camera, 400, 300);
}

static rk_lens lens_of(float focal_distance, float aperture, rk_focal_surface focal)
{
    return (rk_lens){.focal_distance = focal_distance, .aperture = aperture, .focal = focal};
}

static rk_dvec3 from_to(rk_dvec3 from, rk_dvec3 to)
{
    return rk_dmadd(to, from, -1);
}

static rk_vec2 random_place(uint32_t i)
{
    return (rk_vec2){400 * unit_float(i, 3), 300 * unit_float(i, 4)};
}

static rk_vec2 random_xi(uint32_t i)
{
    return (rk_vec2){unit_float(i, 5), unit_float(i, 6)};
}

/* --- The disk --------------------------------------------------------------------------------- */

static rk_vec2 lens_disk(rk_vec2 xi)
{
    return rk_disk_at(RK_DISK_CONCENTRIC, xi);
}

static void check_disk(float xi_x, float xi_y, double x, double y)
{
    rk_vec2 got = lens_disk((rk_vec2){xi_x, xi_y});
    rk_check(fabs((double)got.x - x) <= 4 * epsilon && fabs((double)got.y - y) <= 4 * epsilon,
             "xi (%g, %g): got (%.9g, %.9g), want (%.9g, %.9g) within %.3g: the square's half side "
             "becomes the radius",
             (double)xi_x, (double)xi_y, (double)got.x, (double)got.y, x, y, 4 * epsilon);
}

static void known_points_of_the_square_have_known_points_on_the_disk(void **state)
{
    (void)state;
    const double diagonal = sqrt(0.5), pi = 3.14159265358979323846;
    check_disk(0.5f, 0.5f, 0, 0);
    check_disk(0.5f, 0.5f - 0x1p-18f, 0, -0x1p-17); /* near the middle, but not the middle */
    check_disk(1, 0.5f, 1, 0);
    check_disk(0.25f, 0.5f, -0.5, 0);
    check_disk(0.5f, 0.75f, 0, 0.5);
    check_disk(0.5f, 0, 0, -1);
    check_disk(1, 1, diagonal, diagonal);
    check_disk(0, 1, -diagonal, diagonal);
    check_disk(0.25f, 0.25f, -0.5 * diagonal, -0.5 * diagonal);
    check_disk(0.75f, 0.25f, 0.5 * diagonal, -0.5 * diagonal);
    /* Half-way along half a side is half of an eighth of a turn. */
    check_disk(1, 0.75f, cos(pi / 8), sin(pi / 8));
    check_disk(0.25f, 1, -sin(pi / 8), cos(pi / 8));
}

static void squares_become_circles(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 10000; i++) {
        rk_vec2 xi = random_xi(i), got = lens_disk(xi);
        double side = fmax(fabs(2 * (double)xi.x - 1), fabs(2 * (double)xi.y - 1));
        rk_check_near(hypot((double)got.x, (double)got.y), side, 4 * epsilon,
                      "xi (%g, %g): the larger of |2 xi - 1| is the distance from the centre",
                      (double)xi.x, (double)xi.y);
    }
}

static void the_disk_is_covered_evenly(void **state)
{
    (void)state;
    enum { rings = 8, sectors = 16, samples = 1 << 18 };
    uint32_t counts[rings][sectors] = {0};
    for (uint32_t i = 0; i < samples; i++) {
        rk_vec2 p = lens_disk(random_xi(i));
        double square = (double)(p.x * p.x + p.y * p.y);
        double turn = atan2((double)p.y, (double)p.x) / (2 * 3.14159265358979323846) + 0.5;
        uint32_t ring = (uint32_t)fmin(rings * square, rings - 1);
        counts[ring][(uint32_t)fmin(sectors * turn, sectors - 1)]++;
    }
    double chi_squared = 0, want = (double)samples / (rings * sectors);
    int ring = 0, sector = 0;
    for (int r = 0; r < rings; r++)
        for (int s = 0; s < sectors; s++) {
            chi_squared += (counts[r][s] - want) * (counts[r][s] - want) / want;
            if (fabs(counts[r][s] - want) > fabs(counts[ring][sector] - want))
                ring = r, sector = s;
        }
    /* 127 degrees of freedom: mean 127, standard deviation sqrt(2 127) = 16. */
    const double most = 127 + 5 * sqrt(2 * 127.0);
    rk_check(
        chi_squared < most,
        "%d points in %d parts of equal area: chi-squared is %.1f, want below %.0f; from radius "
        "%.3g to %.3g, %.4g to %.4g degrees, there are %u, want about %.0f",
        samples, rings * sectors, chi_squared, most, sqrt((double)ring / rings),
        sqrt((ring + 1.0) / rings), sector * 360.0 / sectors - 180,
        (sector + 1) * 360.0 / sectors - 180, counts[ring][sector], want);
}

static void neighbours_in_the_square_are_neighbours_on_the_disk(void **state)
{
    (void)state;
    double widest = 0;
    for (uint32_t i = 0; i < 20000; i++) {
        rk_vec2 a = random_xi(i), b = {a.x + 0.01f * (unit_float(i, 7) - 0.5f),
                                       a.y + 0.01f * (unit_float(i, 8) - 0.5f)};
        rk_vec2 p = lens_disk(a), q = lens_disk(b);
        double apart = hypot((double)(p.x - q.x), (double)(p.y - q.y));
        double beside = hypot((double)(a.x - b.x), (double)(a.y - b.y));
        /* Along a side at most 2 (1 + (pi / 4)^2)^.5, across it 2 pi / 4: below 3 together. */
        rk_check(apart <= 3 * beside + 8 * epsilon,
                 "xi (%g, %g) and (%g, %g) are %g apart, their points of the disk %g, want %g at "
                 "most: the disk is torn",
                 (double)a.x, (double)a.y, (double)b.x, (double)b.y, beside, apart, 3 * beside);
        widest = fmax(widest, apart);
    }
    /* The square is as wide as the disk's radius. */
    rk_check(widest > 0.005,
             "points 0.01 apart are at most %g apart on the disk: does it have the radius 1?",
             widest);
}

/* --- Rays ------------------------------------------------------------------------------------- */

/* The intersection of the pinhole ray through (x, y) with the focal surface, in double. */
static rk_dvec3 focus_of(const rk_lens *lens, const rk_view *view, rk_vec2 place)
{
    double right = ((double)place.x - 0.5 * (double)view->width) * (double)view->pixel;
    double up = (0.5 * (double)view->height - (double)place.y) * (double)view->pixel;
    rk_dvec3 through = rk_widen(view->forward);
    through = rk_dmadd(through, rk_widen(view->right), right);
    through = rk_dmadd(through, rk_widen(view->up), up);
    double f = (double)lens->focal_distance;
    double along = lens->focal == RK_FOCAL_PLANE ? f : f / rk_dlength(through);
    return rk_dmadd(rk_widen(view->position), through, along);
}

static double distance_to(const rk_ray *ray, rk_dvec3 point)
{
    rk_dvec3 direction = rk_widen(ray->direction);
    rk_dvec3 apart = rk_dcross(from_to(rk_widen(ray->origin), point), direction);
    return rk_dlength(apart) / rk_dlength(direction);
}

static void rays_start_on_a_disk_in_the_cameras_own_axes(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_view view = turned_view(i);
        rk_lens lens = lens_of(2, 400, i & 1 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE);
        rk_vec2 place = random_place(i), xi = random_xi(i), disk = lens_disk(xi);
        rk_ray ray = rk_lens_ray(&lens, &view, place.x, place.y, xi);
        rk_vec3 offset = rk_sub(ray.origin, view.position);
        /* Roundings of a position up to 5 from the origin. */
        const double tolerance = 2 * 5 * epsilon;
        const rk_vec3 axes[] = {view.forward, view.right, view.up};
        const char *const names[] = {"view.forward, to which it is perpendicular", "view.right",
                                     "view.up"};
        const double x = 0.2 * (double)disk.x, y = 0.2 * (double)disk.y;
        const double wanted[] = {0, x, y}, exchanged[] = {0, y, x};
        rk_check(rk_length(offset) > 0,
                 "aperture 400: the ray starts at the lens's centre, want it at its lens point");
        for (int k = 0; k < 3; k++)
            rk_check_near_or(
                rk_dot(offset, axes[k]), wanted[k], tolerance,
                RK_MISTAKES({2 * wanted[k], "the aperture is the lens's radius, not its diameter"},
                            {10 * wanted[k], "the aperture is in hundredths of a unit"},
                            {x * (double)axes[k].x + y * (double)axes[k].y,
                             "the lens lies along x and y of the world, not of the view"},
                            {k == 0 ? x : 0, "the lens lies along view.forward, not view.right"},
                            {k == 0 ? y : 0, "the lens lies along view.forward, not view.up"},
                            {exchanged[k], "x and y of the disk are exchanged"}),
                "aperture 400, point (%g, %g) of the disk: its offset on the lens along %s",
                (double)disk.x, (double)disk.y, names[k]);
    }
}

static void the_aperture_is_the_diameter_in_thousandths_of_a_unit(void **state)
{
    (void)state;
    rk_camera camera = {.distance = 3, .fov = 50};
    rk_view view = rk_view_of(&camera, 400, 300);
    const float apertures[] = {1, 10, 50, 1000};
    for (int i = 0; i < 4; i++) {
        rk_lens lens = lens_of(1.8f, apertures[i], RK_FOCAL_PLANE);
        rk_ray left = rk_lens_ray(&lens, &view, 100, 100, (rk_vec2){0, 0.5f});
        rk_ray right = rk_lens_ray(&lens, &view, 100, 100, (rk_vec2){1, 0.5f});
        rk_check_near(rk_length(rk_sub(right.origin, left.origin)), 0.001 * (double)apertures[i],
                      8 * epsilon, "aperture %g: from rim to rim", (double)apertures[i]);
    }
}

/* The mistake by which the ray misses its focus: other points that it may go through instead. */
static const char *mistake_of_ray(const rk_lens *lens, const rk_view *view, rk_vec2 place,
                                  const rk_ray *ray, double tolerance)
{
    bool is_plane = lens->focal == RK_FOCAL_PLANE;
    rk_lens other = *lens;
    other.focal = is_plane ? RK_FOCAL_SPHERE : RK_FOCAL_PLANE;
    rk_dvec3 offset = from_to(rk_widen(view->position), rk_widen(ray->origin));
    rk_dvec3 focus = focus_of(lens, view, place);
    if (distance_to(ray, focus_of(&other, view, place)) <= 2 * tolerance)
        return is_plane ? "; it meets the focal sphere there: is the focal distance measured along "
                          "the ray, not along view.forward?"
                        : "; it meets the focal plane there: is the focal distance measured along "
                          "view.forward, not along the ray?";
    if (distance_to(ray, rk_dmadd(focus, offset, 2)) <= 4 * tolerance)
        return RK_EXAMPLE_IF "the offset on the lens is added to the way to the focus, not "
                             "subtracted";
    if (distance_to(ray, rk_dmadd(focus, offset, 1)) <= 4 * tolerance)
        return RK_EXAMPLE_IF "the ray keeps the pinhole's direction";
    return "";
}

static void check_intersection(rk_focal_surface focal)
{
    for (uint32_t i = 0; i < 2000; i++) {
        rk_view view = turned_view(i);
        if (i % 4 == 3)
            view.position = rk_vec(1e4f, -3e4f, 2e4f);
        rk_lens lens = lens_of(exp2f(6 * unit_float(i, 7) - 2), 100, focal);
        rk_vec2 place = random_place(i);
        rk_dvec3 focus = focus_of(&lens, &view, place);
        double f = rk_dlength(from_to(rk_widen(view.position), focus));
        float apart = 0; /* the origins: rays that are one and the same converge nowhere */
        for (uint32_t k = 0; k < 8; k++) {
            rk_ray ray = rk_lens_ray(&lens, &view, place.x, place.y, random_xi(8 * i + k));
            double missed = distance_to(&ray, focus);
            apart = rk_max(apart, rk_length(rk_sub(ray.origin, view.position)));
            /* One rounding of the origin, and a dozen of the direction times f. */
            double tolerance = epsilon * ((double)rk_length(view.position) + 12 * f);
            rk_check(
                missed <= tolerance,
                "point (%g, %g), focused at %g: the ray of xi (%g, %g) misses the focus by %g, "
                "want %.3g at most%s",
                (double)place.x, (double)place.y, (double)lens.focal_distance,
                (double)random_xi(8 * i + k).x, (double)random_xi(8 * i + k).y, missed, tolerance,
                mistake_of_ray(&lens, &view, place, &ray, tolerance));
        }
        rk_check(apart > 0,
                 "point (%g, %g), focused at %g: all rays start at the lens's centre, want them "
                 "all over the lens",
                 (double)place.x, (double)place.y, (double)lens.focal_distance);
    }
}

static void rays_of_a_picture_point_converge_on_the_focal_plane(void **state)
{
    (void)state;
    check_intersection(RK_FOCAL_PLANE);
}

static void rays_of_a_picture_point_converge_on_the_focal_sphere(void **state)
{
    (void)state;
    check_intersection(RK_FOCAL_SPHERE);
}

static void check_pinhole_ray(const rk_lens *lens, const rk_view *view, rk_vec2 place, rk_vec2 xi,
                              const char *hint)
{
    rk_ray got = rk_lens_ray(lens, view, place.x, place.y, xi);
    rk_ray want = rk_view_ray(view, place.x, place.y);
    rk_check(memcmp(&got.direction, &want.direction, sizeof got.direction) == 0 &&
                 rk_length(rk_sub(got.origin, want.origin)) == 0,
             "point (%g, %g), %s: direction (%.9g, %.9g, %.9g), want (%.9g, %.9g, %.9g); start off "
             "by %.3g",
             (double)place.x, (double)place.y, hint, (double)got.direction.x,
             (double)got.direction.y, (double)got.direction.z, (double)want.direction.x,
             (double)want.direction.y, (double)want.direction.z,
             (double)rk_length(rk_sub(got.origin, want.origin)));
    rk_check(isinf(got.t_max) && got.t_max > 0, "point (%g, %g), %s: t_max is %g, want inf",
             (double)place.x, (double)place.y, hint, (double)got.t_max);
}

static void a_ray_from_the_lens_centre_is_the_pinhole_ray_to_the_bit(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_view view = turned_view(i);
        rk_lens lens =
            lens_of(0.1f + 5 * unit_float(i, 7), 300, i & 1 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE);
        check_pinhole_ray(&lens, &view, random_place(i), (rk_vec2){0.5f, 0.5f},
                          "xi (0.5, 0.5): the ray from the lens's centre is not rk_view_ray's");
    }
}

static void with_aperture_0_every_ray_is_the_pinhole_ray_to_the_bit(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_view view = turned_view(i);
        rk_lens lens =
            lens_of(0.1f + 5 * unit_float(i, 7), 0, i & 1 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE);
        check_pinhole_ray(&lens, &view, random_place(i), random_xi(i),
                          "aperture 0: the ray is not rk_view_ray's");
    }
}

static void directions_are_unit_and_rays_have_no_end(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_view view = turned_view(i);
        rk_lens lens = lens_of(1.8f, 500, i & 1 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE);
        rk_vec2 place = random_place(i);
        rk_ray ray = rk_lens_ray(&lens, &view, place.x, place.y, random_xi(i));
        rk_check_near(rk_length(ray.direction), 1, 4 * epsilon,
                      "point (%g, %g): length of the direction; see rk_normalize", (double)place.x,
                      (double)place.y);
        rk_check(isinf(ray.t_max) && ray.t_max > 0, "point (%g, %g): t_max is %g, want inf",
                 (double)place.x, (double)place.y, (double)ray.t_max);
        rk_check(rk_dot(ray.direction, view.forward) > 0,
                 "point (%g, %g): the direction (%g, %g, %g) leads backwards", (double)place.x,
                 (double)place.y, (double)ray.direction.x, (double)ray.direction.y,
                 (double)ray.direction.z);
    }
}

static void rays_do_not_depend_on_the_cameras_place(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_view near = turned_view(i), far = near;
        far.position = rk_vec(1e4f, -3e4f, 2e4f);
        rk_lens lens = lens_of(1.8f, 300, i & 1 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE);
        rk_vec2 place = random_place(i), xi = random_xi(i);
        rk_ray a = rk_lens_ray(&lens, &near, place.x, place.y, xi);
        rk_ray b = rk_lens_ray(&lens, &far, place.x, place.y, xi);
        rk_check(
            rk_length(a.direction) > 0 &&
                memcmp(&a.direction, &b.direction, sizeof a.direction) == 0,
            "the same camera at (1e4, -3e4, 2e4): the direction (%.9g, %.9g, %.9g) became (%.9g, "
            "%.9g, %.9g): far from the origin, differences of positions have few digits",
            (double)a.direction.x, (double)a.direction.y, (double)a.direction.z,
            (double)b.direction.x, (double)b.direction.y, (double)b.direction.z);
        rk_vec3 ahead = rk_view_ray(&near, place.x, place.y).direction;
        rk_vec3 direction = rk_normalize(a.direction);
        rk_check(
            memcmp(&direction, &ahead, sizeof ahead) != 0,
            "the ray from a random point of the lens has the same direction as the one through "
            "its centre: rays of a picture point meet in focus, they are not parallel");
    }
}

/* The ray against origin and focus in double. */
static void check_lens_ray(const rk_lens *lens, const rk_view *view, rk_vec2 place, rk_vec2 xi)
{
    rk_lens lens_before = *lens;
    rk_view view_before = *view;
    rk_ray ray = rk_lens_ray(lens, view, place.x, place.y, xi);
    rk_check(memcmp(lens, &lens_before, sizeof *lens) == 0 &&
                 memcmp(view, &view_before, sizeof *view) == 0,
             "rk_lens_ray changed the lens or the view, which are the caller's");
    rk_vec2 disk = lens_disk(xi);
    double radius = 0.0005 * (double)lens->aperture;
    rk_dvec3 offset = rk_dscale(rk_widen(view->right), radius * (double)disk.x);
    offset = rk_dmadd(offset, rk_widen(view->up), radius * (double)disk.y);
    rk_dvec3 origin = rk_dmadd(rk_widen(view->position), offset, 1);
    double off = rk_dlength(from_to(origin, rk_widen(ray.origin)));
    /* Roundings of the offset, and one of each coordinate of the sum. */
    double tolerance = epsilon * (8 * radius + 2 * rk_dlength(origin));
    rk_check(off <= tolerance,
             "camera at (%g, %g, %g), aperture %g, point (%g, %g) of the disk: the ray starts %.3g "
             "from its lens point, want %.3g at most",
             (double)view->position.x, (double)view->position.y, (double)view->position.z,
             (double)lens->aperture, (double)disk.x, (double)disk.y, off, tolerance);
    rk_view at_0 = *view;
    at_0.position = rk_vec(0, 0, 0);
    rk_dvec3 to = from_to(offset, focus_of(lens, &at_0, place));
    rk_dvec3 want = rk_dscale(to, 1 / rk_dlength(to));
    off = rk_dlength(from_to(want, rk_widen(ray.direction)));
    /* A dozen roundings of the sides of a triangle, over its third side. */
    tolerance = epsilon * 12 * (rk_dlength(offset) + rk_dlength(focus_of(lens, &at_0, place))) /
                rk_dlength(to);
    rk_check(off <= tolerance,
             "focal distance %g, aperture %g, picture point (%g, %g), xi (%g, %g): got the "
             "direction (%.9g, %.9g, %.9g), want (%.9g, %.9g, %.9g) within %.3g",
             (double)lens->focal_distance, (double)lens->aperture, (double)place.x, (double)place.y,
             (double)xi.x, (double)xi.y, (double)ray.direction.x, (double)ray.direction.y,
             (double)ray.direction.z, want.x, want.y, want.z, tolerance);
    rk_check(isinf(ray.t_max) && ray.t_max > 0, "t_max is %g, want inf", (double)ray.t_max);
}

static void a_ray_depends_on_lens_view_picture_point_and_xi(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 500; i++) {
        rk_view view = turned_view(i), other = turned_view(i + 1);
        rk_lens lens = lens_of(1 + unit_float(i, 7), 300, i & 1 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE);
        rk_vec2 place = random_place(i), xi = random_xi(i);
        check_lens_ray(&lens, &view, place, xi);
        /* Each call differs from the one before in one thing. */
        lens.focal_distance *= 1.5f;
        check_lens_ray(&lens, &view, place, xi);
        lens.aperture *= 2;
        check_lens_ray(&lens, &view, place, xi);
        lens.focal = lens.focal == RK_FOCAL_PLANE ? RK_FOCAL_SPHERE : RK_FOCAL_PLANE;
        check_lens_ray(&lens, &view, place, xi);
        place.x = 400 - place.x;
        check_lens_ray(&lens, &view, place, xi);
        place.y = 300 - place.y;
        check_lens_ray(&lens, &view, place, xi);
        xi.x = 1 - xi.x;
        check_lens_ray(&lens, &view, place, xi);
        xi.y = 1 - xi.y;
        check_lens_ray(&lens, &view, place, xi);
        view.position = rk_vec(1e4f, -3e4f, 2e4f);
        check_lens_ray(&lens, &view, place, xi);
        view.right = other.right;
        view.up = other.up;
        view.forward = other.forward;
        check_lens_ray(&lens, &view, place, xi);
        view.pixel *= 2;
        check_lens_ray(&lens, &view, place, xi);
        view.width += 200;
        view.height += 100;
        check_lens_ray(&lens, &view, place, xi);
    }
}

/* A scene, its camera and its lens in other units of length. */
static void rays_do_not_depend_on_the_unit_of_length(void **state)
{
    (void)state;
    const float lenses[][2] = {{1e-3f, 1e6f}, {1e-3f, 1e-3f}, {1e6f, 1e6f}, {1e6f, 1e-3f}};
    for (uint32_t i = 0; i < 400; i++) {
        rk_view view = turned_view(i);
        rk_lens lens =
            lens_of(lenses[i % 4][0], lenses[i % 4][1], i & 8 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE);
        check_lens_ray(&lens, &view, random_place(i), random_xi(i));
    }
    for (uint32_t i = 0; i < 500; i++) {
        rk_view view = turned_view(i);
        int exponent = (int)(i % 201) - 100;
        view.position = rk_vec(0, 0, 0);
        rk_lens lens = lens_of(ldexpf(1 + unit_float(i, 7), exponent), ldexpf(400, exponent),
                               i & 1 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE);
        check_lens_ray(&lens, &view, random_place(i), random_xi(i));
    }
}

static void a_lens_focused_at_infinity_sends_parallel_rays(void **state)
{
    (void)state;
    const float far[] = {INFINITY, 1e20f, 1e30f, 3e38f};
    for (uint32_t i = 0; i < 1000; i++) {
        rk_view view = turned_view(i);
        rk_lens lens = lens_of(far[i / 2 % 4], 300, i & 1 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE);
        rk_vec2 place = random_place(i);
        rk_ray ray = rk_lens_ray(&lens, &view, place.x, place.y, random_xi(i));
        rk_vec3 got = ray.direction;
        rk_vec3 want = rk_view_ray(&view, place.x, place.y).direction;
        rk_check(/* roundings of a unit vector */
                 rk_length(rk_sub(got, want)) <= 4 * (float)epsilon,
                 "focused %g away: got the direction (%.9g, %.9g, %.9g), want the pinhole's, "
                 "(%.9g, %.9g, %.9g), from every point of the lens",
                 (double)lens.focal_distance, (double)got.x, (double)got.y, (double)got.z,
                 (double)want.x, (double)want.y, (double)want.z);
        rk_check(rk_length(rk_sub(ray.origin, view.position)) > 0,
                 "focused %g away: the ray starts at the lens's centre, want it at its lens point",
                 (double)lens.focal_distance);
    }
}

/* --- Circles of confusion --------------------------------------------------------------------- */

static const char *const focal_names[] = {[RK_FOCAL_PLANE] = "plane", [RK_FOCAL_SPHERE] = "sphere"};

static double cosine_of(const rk_view *view, const rk_ray *ray)
{
    return rk_ddot(rk_widen(ray->direction), rk_widen(view->forward));
}

/* Why a diameter is no number. */
static const char *if_nan(float diameter)
{
    return isnan(diameter) ? "; inf / inf, inf - inf and 0 inf are not numbers: divide first" : "";
}

static void a_point_in_focus_has_no_circle_of_confusion(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_view view = turned_view(i);
        rk_vec2 place = random_place(i);
        rk_ray ray = rk_view_ray(&view, place.x, place.y);
        float f = 0.5f + 4 * unit_float(i, 7);
        rk_lens plane = lens_of(f, 50, RK_FOCAL_PLANE), sphere = lens_of(f, 50, RK_FOCAL_SPHERE);
        /* 1 / f and 1 / d are equal up to six roundings, also if d is a product with a length. */
        double infinitely_far = 0.05 / ((double)f * (double)view.pixel);
        double cosine = cosine_of(&view, &ray);
        rk_check_near_or(
            rk_lens_coc_diameter(&plane, &view, &ray, f / (float)cosine), 0,
            6 * epsilon * infinitely_far,
            RK_MISTAKES({infinitely_far * (1 - cosine),
                         "d is the distance along the ray, not the depth, which a plane needs"}),
            "point (%g, %g): circle of the point at the depth %g, on the focal plane",
            (double)place.x, (double)place.y, (double)f);
        rk_check_near_or(
            rk_lens_coc_diameter(&sphere, &view, &ray, f), 0, 6 * epsilon * infinitely_far / cosine,
            RK_MISTAKES({infinitely_far * (1 / cosine - 1),
                         "d is the depth, not the distance along the ray, which a sphere needs"},
                        {infinitely_far * (1 / cosine - 1) / cosine,
                         "d is the depth, not the distance along the ray, which a sphere needs"}),
            "point (%g, %g): circle of the point at the distance %g, on the focal sphere",
            (double)place.x, (double)place.y, (double)f);
    }
}

static void a_pinhole_has_no_circles_of_confusion(void **state)
{
    (void)state;
    const float distances[] = {1e-6f, 1e-3f, 0.5f, 2, 1e6f, 1e30f, INFINITY};
    for (uint32_t i = 0; i < 49; i++)
        for (int focal = RK_FOCAL_PLANE; focal <= RK_FOCAL_SPHERE; focal++) {
            rk_view view = turned_view(i);
            rk_vec2 place = random_place(i);
            rk_ray ray = rk_view_ray(&view, place.x, place.y);
            float t = distances[i % 7];
            rk_lens lens = lens_of(distances[i / 7], 0, (rk_focal_surface)focal);
            float got = rk_lens_coc_diameter(&lens, &view, &ray, t);
            rk_check_near(got, 0, 0, "aperture 0, focal %s at %g: circle of a point %g away%s",
                          focal_names[focal], (double)lens.focal_distance, (double)t, if_nan(got));
        }
}

/* |d - f| / d x aperture, over the side of a pixel on the focal surface. */
static void the_circle_of_confusion_equals_the_closed_form(void **state)
{
    (void)state;
    rk_camera camera = {.distance = 3, .fov = 50};
    rk_view view = rk_view_of(&camera, 800, 800);
    rk_ray ahead = rk_view_ray(&view, 400, 400);
    double pixel = 2 * tan(25 * 3.14159265358979323846 / 180) / 800;
    const float distances[] = {1e-30f, 1e-15f, 1e-6f, 0.01f, 0.5f,  1,     1.5f, 2,
                               4,      100,    1e6f,  1e15f, 1e20f, 1e30f, 3e38f};
    for (int i = 0; i < 15; i++)
        for (int focal = RK_FOCAL_PLANE; focal <= RK_FOCAL_SPHERE; focal++) {
            rk_lens lens = lens_of(1.8f, 50, (rk_focal_surface)focal);
            double d = (double)distances[i], f = (double)lens.focal_distance;
            double want = 0.05 * fabs(d - f) / d / (f * pixel);
            rk_check_near_or(
                rk_lens_coc_diameter(&lens, &view, &ahead, distances[i]), want, 1e-5 * want,
                RK_MISTAKES({want / 2, "the circle's radius is returned, not its diameter"},
                            {10 * want, "the aperture is in hundredths of a unit"},
                            {want * f, "the pixel's size is that at the distance 1, not in focus"},
                            {want * d / f, "|d - f| is divided by f, not by d"},
                            {want * pixel * pixel, "view->pixel is a factor, not the divisor"}),
                "aperture 50, focal %s at 1.8: circle of a point %g straight ahead, %s the focus",
                focal_names[focal], d, d < f ? "before" : "behind");
        }
}

/* The circle of a point at `t`, neither much nearer than the focus nor much farther. */
static void check_circle(const rk_lens *lens, const rk_view *view, const rk_ray *ray, float t)
{
    rk_lens lens_before = *lens;
    rk_view view_before = *view;
    rk_ray ray_before = *ray;
    double got = (double)rk_lens_coc_diameter(lens, view, ray, t);
    rk_check(memcmp(lens, &lens_before, sizeof *lens) == 0 &&
                 memcmp(view, &view_before, sizeof *view) == 0 &&
                 memcmp(ray, &ray_before, sizeof *ray) == 0,
             "rk_lens_coc_diameter changed the lens, the view or the ray, which are the caller's");
    bool plane = lens->focal == RK_FOCAL_PLANE;
    double cosine = cosine_of(view, ray), f = (double)lens->focal_distance, d = (double)t;
    double largest = 0.001 * (double)lens->aperture / (f * (double)view->pixel);
    if (plane)
        d *= cosine;
    else
        largest /= cosine;
    double other = plane ? (double)t : (double)t * cosine;
    /* A few roundings of f / d, or of 1. */
    rk_check_near_or(
        got, largest * fabs(1 - f / d), largest * (1 + f / d) * 0x1p-20,
        RK_MISTAKES({largest * fabs(1 - f / other), plane ? "d is the distance, not the depth"
                                                          : "d is the depth, not the distance"},
                    {largest * (plane ? 1 : cosine) * fabs(1 - f / d),
                     "a pixel on the sphere is as large as one straight ahead"},
                    {largest * (plane ? 1 : cosine * cosine) * fabs(1 - f / d),
                     "the circle is multiplied by the cosine, not divided"}),
        "aperture %g, focal %s at %g, pixel %g: circle of a point %g away, in a direction "
        "whose cosine is %g: d is %g, its %s",
        (double)lens->aperture, focal_names[lens->focal], f, (double)view->pixel, (double)t, cosine,
        d, plane ? "depth" : "distance");
}

static void a_focal_plane_uses_depth_and_a_sphere_distance(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_view view = turned_view(i);
        if (i % 2) /* a wide angle, far from the origin */
            view.pixel *= 3, view.position = rk_vec(1e4f, -3e4f, 2e4f);
        rk_vec2 place = random_place(i);
        rk_ray ray = rk_view_ray(&view, place.x, place.y);
        float t = 0.5f + 4 * unit_float(i, 7);
        rk_lens plane = lens_of(1.8f, 50, RK_FOCAL_PLANE);
        rk_lens sphere = lens_of(1.8f, 50, RK_FOCAL_SPHERE);
        check_circle(&plane, &view, &ray, t);
        check_circle(&sphere, &view, &ray, t);
    }
}

static void a_circle_depends_on_lens_view_ray_and_distance(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 500; i++) {
        rk_view view = turned_view(i);
        rk_vec2 place = random_place(i);
        rk_ray ray = rk_view_ray(&view, place.x, place.y);
        rk_lens lens = lens_of(1 + unit_float(i, 7), 50, i & 1 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE);
        float t = 1 + 4 * unit_float(i, 8);
        check_circle(&lens, &view, &ray, t);
        /* Each call differs from the one before in one thing. */
        t *= 1.25f;
        check_circle(&lens, &view, &ray, t);
        lens.focal_distance *= 1.5f;
        check_circle(&lens, &view, &ray, t);
        lens.aperture *= 2;
        check_circle(&lens, &view, &ray, t);
        lens.focal = lens.focal == RK_FOCAL_PLANE ? RK_FOCAL_SPHERE : RK_FOCAL_PLANE;
        check_circle(&lens, &view, &ray, t);
        view.pixel *= 2;
        check_circle(&lens, &view, &ray, t);
        ray.direction = view.forward;
        check_circle(&lens, &view, &ray, t);
    }
}

/* A scene, its camera and its lens in other units of length. */
static void circles_do_not_depend_on_the_unit_of_length(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 500; i++) {
        rk_view view = turned_view(i);
        view.position = rk_vec(0, 0, 0);
        rk_vec2 place = random_place(i);
        rk_ray ray = rk_view_ray(&view, place.x, place.y);
        int exponent = (int)(i % 201) - 100;
        rk_lens lens = lens_of(ldexpf(1 + unit_float(i, 7), exponent), ldexpf(400, exponent),
                               i & 1 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE);
        check_circle(&lens, &view, &ray, ldexpf(0.5f + 4 * unit_float(i, 8), exponent));
    }
}

/* Where d / f exceeds the largest float, too. */
static void check_far_points(const rk_lens *lens, const rk_view *view, rk_vec2 place)
{
    rk_ray ray = rk_view_ray(view, place.x, place.y);
    double cosine = lens->focal == RK_FOCAL_SPHERE ? cosine_of(view, &ray) : 1;
    double want = 0.025 / (double)view->pixel / cosine;
    const float far[] = {INFINITY, 1e10f, 1e20f, 1e30f, 3e38f};
    for (int k = 0; k < 5; k++)
        rk_check_near(rk_lens_coc_diameter(lens, view, &ray, far[k]), want, 1e-5 * want,
                      "point (%g, %g), aperture %g, focal %s at %g: circle of a point %g away, "
                      "where |d - f| / d is 1; on a sphere also divided by the cosine",
                      (double)place.x, (double)place.y, (double)lens->aperture,
                      focal_names[lens->focal], (double)lens->focal_distance, (double)far[k]);
}

static void the_circle_of_an_infinitely_far_point_is_finite(void **state)
{
    (void)state;
    const float units[] = {1, 1e-20f, 1e-30f};
    for (uint32_t i = 0; i < 200; i++) {
        rk_view view = turned_view(i);
        rk_vec2 place = i ? random_place(i) : (rk_vec2){200, 150};
        for (int unit = 0; unit < 3; unit++)
            for (int focal = RK_FOCAL_PLANE; focal <= RK_FOCAL_SPHERE; focal++) {
                rk_lens lens = lens_of(2 * units[unit], 50 * units[unit], (rk_focal_surface)focal);
                check_far_points(&lens, &view, place);
            }
    }
}

static void a_lens_focused_at_infinity_blurs_what_is_near(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 200; i++) {
        rk_view view = turned_view(i);
        rk_vec2 place = random_place(i);
        rk_ray ray = rk_view_ray(&view, place.x, place.y);
        double cosine = cosine_of(&view, &ray), pixel = (double)view.pixel;
        for (int focal = RK_FOCAL_PLANE; focal <= RK_FOCAL_SPHERE; focal++) {
            const float far[] = {INFINITY, 1e10f, 1e20f, 1e30f, 3e38f};
            rk_lens lens = lens_of(far[i % 5], 50, (rk_focal_surface)focal);
            double behind = 0.05 / ((double)far[i % 5] * pixel);
            if (focal == RK_FOCAL_SPHERE)
                behind /= cosine;
            rk_check_near(rk_lens_coc_diameter(&lens, &view, &ray, INFINITY), behind, 1e-5 * behind,
                          "focal %s at %g: circle of an infinitely far point", focal_names[focal],
                          (double)lens.focal_distance);
            /* A / d on the plane, at the depth d = t cosine; on the sphere d = t. */
            const float near[] = {2, 1000, 1e-6f, 1e-20f};
            /* f / d may be computed, which is too large for a float where both are extreme. */
            for (int k = 0; k < (isinf(far[i % 5]) ? 4 : 2); k++) {
                double want = 0.05 / ((double)near[k] * pixel * cosine);
                rk_check_near(rk_lens_coc_diameter(&lens, &view, &ray, near[k]), want, 1e-5 * want,
                              "aperture 50, focal %s at %g: circle of a point %g away",
                              focal_names[focal], (double)lens.focal_distance, (double)near[k]);
            }
        }
    }
}

/* The first intersection of the ray from a lens's point through `point` with the focal surface. */
static rk_vec3 focus_behind(const rk_lens *lens, const rk_view *view, rk_vec3 from, rk_vec3 point)
{
    rk_dvec3 o = from_to(rk_widen(view->position), rk_widen(from));
    rk_dvec3 towards = from_to(rk_widen(from), rk_widen(point)), ahead = rk_widen(view->forward);
    double f = (double)lens->focal_distance, along;
    if (lens->focal == RK_FOCAL_PLANE) {
        along = (f - rk_ddot(o, ahead)) / rk_ddot(towards, ahead);
    } else { /* |o + s towards| = f */
        double a = rk_ddot(towards, towards), b = rk_ddot(o, towards);
        along = (sqrt(b * b - a * (rk_ddot(o, o) - f * f)) - b) / a;
    }
    rk_dvec3 focus = rk_dmadd(rk_widen(from), towards, along);
    return rk_vec((float)focus.x, (float)focus.y, (float)focus.z);
}

/* Light from a point through the rim of the lens contributes to the pixel onto which the ray's
 * intersection with the focal surface projects: all these projections make the rim of the circle.
 */
static void the_rim_of_the_lens_draws_the_rim_of_the_circle(void **state)
{
    (void)state;
    int wide = 0; /* circles; a pinhole has none, and this lens 3,750 */
    for (uint32_t i = 0; i < 4000; i++) {
        rk_view view = turned_view(i);
        rk_focal_surface focal = i & 1 ? RK_FOCAL_PLANE : RK_FOCAL_SPHERE;
        rk_lens lens = lens_of(1 + 2 * unit_float(i, 7), 10, focal);
        rk_vec2 place = random_place(i), image_point, rim = {1, unit_float(i, 9)};
        rk_ray pinhole = rk_view_ray(&view, place.x, place.y);
        float t = 0.8f + 4 * unit_float(i, 8), depth;
        rk_vec3 point = rk_madd(pinhole.origin, pinhole.direction, t);
        rk_ray from_rim = rk_lens_ray(&lens, &view, place.x, place.y, rim);
        rk_vec3 focus = focus_behind(&lens, &view, from_rim.origin, point);
        rk_check(rk_view_project(&view, focus, &image_point, &depth), "the focus is in front");
        double got = hypot((double)(image_point.x - place.x), (double)(image_point.y - place.y));
        double diameter = (double)rk_lens_coc_diameter(&lens, &view, &pinhole, t),
               want = diameter / 2;
        rk_check(diameter >= 0 && isfinite(diameter),
                 "focal %s at %g, t = %g: the circle's diameter is %g pixels, want 0 or more",
                 focal_names[focal], (double)lens.focal_distance, (double)t, diameter);
        wide += diameter > 0.1;
        /* 24 roundings of pixels up to 400; on a sphere also the next order in A / d, .0125. */
        double tolerance = 400 * 24 * epsilon + (focal == RK_FOCAL_SPHERE ? 0.0125 * want : 0);
        rk_check_near(
            got, want, tolerance,
            "point (%g, %g), focal %s at %g, t = %g: by its rays the rim is this many pixels "
            "from the centre; want half of rk_lens_coc_diameter",
            (double)place.x, (double)place.y, focal_names[focal], (double)lens.focal_distance,
            (double)t);
        rk_ray back = rk_lens_ray(&lens, &view, image_point.x, image_point.y, rim);
        rk_check(distance_to(&back, rk_widen(point)) <= 5 * 24 * epsilon,
                 "point (%g, %g), the circle's rim: its ray of xi (1, %g) misses the point by %g, "
                 "want %.3g at most",
                 (double)image_point.x, (double)image_point.y, (double)rim.y,
                 distance_to(&back, rk_widen(point)), 5 * 24 * epsilon);
    }
    rk_check(wide > 2000, "%d of 4000 circles are wider than a tenth of a pixel, want most", wide);
}

/* --- Pixels that circles reach ---------------------------------------------------------------- */

/* The diameter of each pixel's circle of confusion. */
typedef struct picture {
    uint32_t width, height;
    float blur[40 * 24];
} picture;

static bool reaches(uint32_t from, uint32_t to, float diameter)
{
    return fabs((double)to - from) <= ceil((double)diameter / 2);
}

/* How circles are marked by mistake. */
typedef enum marking {
    ROWS_ALONE,
    COLUMNS_ALONE,
    ROUNDED_DOWN,
    DIAMETER,
    HALF_IS_SHARP,
    MARKINGS
} marking;

static const char *const markings[] = {
    [ROWS_ALONE] = RK_EXAMPLE_IF "sums run along rows alone, not along columns too (step 5)",
    [COLUMNS_ALONE] = RK_EXAMPLE_IF "sums run along columns alone, not along rows too (step 5)",
    [ROUNDED_DOWN] = RK_EXAMPLE_IF "half the diameter is rounded down, not up",
    [DIAMETER] = RK_EXAMPLE_IF "circles reach as far as their diameter, not their radius",
    [HALF_IS_SHARP] = RK_EXAMPLE_IF "a diameter of exactly half a pixel counts as a point",
};

/* What the circle of one pixel adds to another. */
static int marked(const picture *p, uint32_t from, uint32_t x, uint32_t y, marking by)
{
    double diameter = (double)p->blur[from], reach = ceil(diameter / 2);
    if (diameter < 0.5 || (by == HALF_IS_SHARP && diameter == 0.5))
        return 0;
    reach = by == ROUNDED_DOWN ? floor(diameter / 2) : by == DIAMETER ? ceil(diameter) : reach;
    double left = from % p->width - reach, right = from % p->width + reach;
    double top = from / p->width - reach, bottom = from / p->width + reach;
    bool in_columns = left <= x && x <= right, in_rows = top <= y && y <= bottom;
    if (by == ROWS_ALONE)
        return in_columns * ((y == fmax(top, 0)) - (y == bottom + 1));
    if (by == COLUMNS_ALONE)
        return in_rows * ((x == fmax(left, 0)) - (x == right + 1));
    return in_columns && in_rows;
}

/* A row is a number longer than the picture is wide. It may be forgotten in the first and the last
 * row of a square, and in the sums. */
enum { SHORT_FIRST_ROW = 1, SHORT_LAST_ROW = 2, SHORT_SUMS = 4, ALL_SHORT = 7 };

static void sum_by_rows_too_short(const picture *p, int which, int32_t *sums)
{
    int width = (int)p->width, height = (int)p->height;
    int first = width + !(which & SHORT_FIRST_ROW), last = width + !(which & SHORT_LAST_ROW);
    int row = width + !(which & SHORT_SUMS);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            double diameter = (double)p->blur[y * width + x], reach = ceil(diameter / 2);
            if (diameter < 0.5)
                continue;
            int left = (int)fmax(x - reach, 0), end = (int)fmin(x + reach + 1, width);
            int top = (int)fmax(y - reach, 0), below = (int)fmin(y + reach + 1, height);
            sums[top * first + left]++;
            sums[top * first + end]--;
            sums[below * last + left]--;
            sums[below * last + end]++;
        }
    for (int y = 0; y < height; y++)
        for (int x = 1; x < width; x++)
            sums[y * row + x] += sums[y * row + x - 1];
    for (int y = 1; y < height; y++)
        for (int x = 0; x < width; x++)
            sums[y * row + x] += sums[(y - 1) * row + x];
}

static bool rows_are_too_short(const picture *p, const int32_t *counts)
{
    uint32_t stride = p->width + 1;
    for (int which = 1; which <= ALL_SHORT; which++) {
        int32_t sums[2 * (40 * 24 + 1)] = {0};
        bool equal = true;
        sum_by_rows_too_short(p, which, sums);
        for (uint32_t y = 0; y < p->height && equal; y++)
            equal = memcmp(&sums[y * stride], &counts[y * stride], p->width * sizeof *sums) == 0;
        if (equal)
            return true;
    }
    return false;
}

/* The mistake that explains all numbers of the picture. */
static const char *mistake_of_counts(const picture *p, const int32_t *counts)
{
    uint32_t pixels = p->width * p->height;
    for (int by = 0; by < MARKINGS; by++) {
        bool equal = pixels > 100; /* in few pixels several mistakes look alike */
        for (uint32_t i = 0; i < pixels && equal; i++) {
            int sum = 0;
            for (uint32_t k = 0; k < pixels; k++)
                sum += marked(p, k, i % p->width, i / p->width, (marking)by);
            equal = counts[i / p->width * (p->width + 1) + i % p->width] == sum;
        }
        if (equal)
            return markings[by];
    }
    if (pixels > 100 && rows_are_too_short(p, counts))
        return RK_EXAMPLE_IF "a row of coc_count is width long somewhere, not width + 1 (step 5)";
    return "";
}

static bool circle_reaches(const picture *p, uint32_t from, uint32_t x, uint32_t y)
{
    float diameter = p->blur[from];
    return diameter >= 0.5f && reaches(from % p->width, x, diameter) &&
           reaches(from / p->width, y, diameter);
}

/* Names one circle that was missed or wrongly counted, if there is one: whose rim is nearest. */
static const char *circle_to_blame(const picture *p, uint32_t x, uint32_t y, int got, int want)
{
    static char said[120];
    double least = INFINITY;
    const char *does = got < want ? "reaches it" : "does not reach it";
    snprintf(said, sizeof said, "%s", want ? "all circles reach it" : "no circle reaches it");
    for (uint32_t i = 0; i < p->width * p->height; i++) {
        double columns = fabs((double)(i % p->width) - x), rows = fabs((double)(i / p->width) - y);
        double beside = fabs(fmax(columns, rows) - ceil((double)p->blur[i] / 2));
        if (p->blur[i] > 0 && circle_reaches(p, i, x, y) == (got < want) &&
            (beside < least || least == (double)INFINITY)) {
            least = beside;
            snprintf(said, sizeof said, "the circle of pixel (%u, %u), diameter %g, %s",
                     i % p->width, i / p->width, (double)p->blur[i],
                     p->blur[i] < 0.5f ? "is a point" : does);
        }
    }
    return said;
}

static bool nothing_is_marked(const picture *p, const int32_t *counts)
{
    for (uint32_t y = 0; y < p->height; y++)
        for (uint32_t x = 0; x < p->width; x++)
            if (counts[y * (p->width + 1) + x] != 0)
                return false;
    return true;
}

static void fail_pixel(const picture *p, const int32_t *counts, uint32_t x, uint32_t y, int want)
{
    int got = counts[y * (p->width + 1) + x];
    rk_check(!nothing_is_marked(p, counts),
             "%u x %u pixels: no pixel is marked, not even (%u, %u): %s", p->width, p->height, x, y,
             circle_to_blame(p, x, y, got, want));
    rk_check(false,
             "%u x %u pixels: pixel (%u, %u) got %d circles, want %d; %s; before the call each "
             "number was 7%s",
             p->width, p->height, x, y, got, want, circle_to_blame(p, x, y, got, want),
             mistake_of_counts(p, counts));
}

/* Compares each pixel with each. Both arrays have `guard` more numbers at both ends. With 0,
 * sanitizers detect reads beyond the ends; otherwise numbers there would be circles that reach all
 * pixels, and must not be overwritten. */
static void check_guarded(const picture *p, size_t guard)
{
    const int32_t untouched = 7; /* a number that sums stay small with */
    size_t pixels = (size_t)p->width * p->height, stride = p->width + 1;
    size_t numbers = stride * (p->height + 1);
    float *blur = malloc((pixels + 2 * guard) * sizeof *blur);
    int32_t *counts = malloc((numbers + 2 * guard) * sizeof *counts);
    rk_check(blur && counts, "there is memory");
    for (size_t i = 0; i < pixels + 2 * guard; i++)
        blur[i] = i >= guard && i < guard + pixels ? p->blur[i - guard] : INFINITY;
    for (size_t i = 0; i < numbers + 2 * guard; i++)
        counts[i] = untouched;
    rk_lens_coc(blur + guard, p->width, p->height, counts + guard);
    rk_check(memcmp(blur + guard, p->blur, pixels * sizeof *blur) == 0,
             "%u x %u pixels: the diameters, which are the caller's, were changed", p->width,
             p->height);
    for (uint32_t y = 0; y < p->height; y++)
        for (uint32_t x = 0; x < p->width; x++) {
            int got = counts[guard + y * stride + x], want = 0;
            for (uint32_t i = 0; i < pixels; i++)
                want += circle_reaches(p, i, x, y);
            if (got != want)
                fail_pixel(p, counts + guard, x, y, want);
        }
    for (size_t i = 0; i < guard; i++)
        rk_check(
            counts[i] == untouched && counts[guard + numbers + i] == untouched,
            "%u x %u pixels: coc_count[%s%zu] was written to, but it has (width + 1) * (height + "
            "1) = %zu numbers",
            p->width, p->height, counts[i] == untouched ? "" : "-",
            counts[i] == untouched ? numbers + i : guard - i, numbers);
    free(counts);
    free(blur);
}

static void check_counts(const picture *p)
{
    check_guarded(p, 0);
    check_guarded(p, p->width + 1);
}

static picture sharp_picture(uint32_t width, uint32_t height)
{
    return (picture){.width = width, .height = height};
}

static void circles_below_half_a_pixel_are_points(void **state)
{
    (void)state;
    picture p = sharp_picture(37, 23);
    for (uint32_t i = 0; i < 37 * 23; i++)
        p.blur[i] = i % 2 ? 0.49f * unit_float(i, 0) : 0.5f - 0x1p-25f; /* the next float */
    check_counts(&p);
    p.blur[5 * 37 + 7] = 0.5f;
    p.blur[0] = 1; /* this is marked, too, or nothing is */
    check_counts(&p);
}

static void a_circle_reaches_every_pixel_that_it_may_touch(void **state)
{
    (void)state;
    /* Also the floats beside whole radii, where one pixel more is reached. */
    const float diameters[] = {0.5f,         1, 2 - 0x1p-23f, 2,  2 + 0x1p-22f, 2.1f, 4,
                               4 + 0x1p-21f, 5, 7.9f,         12, 16 + 0x1p-19f};
    for (int i = 0; i < 12; i++) {
        picture p = sharp_picture(37, 23);
        p.blur[11 * 37 + 18] = diameters[i];
        p.blur[0] = 1; /* this is marked, too, or nothing is */
        check_counts(&p);
    }
}

/* The example in the chapter. */
static void check_a_square_at_the_upper_border(void)
{
    static const int32_t want[4][6] = {{0, 1, 1, 1, 0, 0}, {0, 1, 1, 1, 0, 0}};
    float blur[4 * 6] = {0};
    int32_t counts[5 * 7];
    blur[2] = 2;
    rk_lens_coc(blur, 6, 4, counts);
    for (int y = 0; y < 4; y++)
        for (int x = 0; x < 6; x++)
            rk_check(counts[7 * y + x] == want[y][x],
                     "6 x 4 pixels, a circle of diameter 2 around pixel (2, 0): pixel (%d, %d) got "
                     "%d circles, want %d",
                     x, y, counts[7 * y + x], want[y][x]);
}

static void circles_end_at_the_border_of_the_picture(void **state)
{
    (void)state;
    check_a_square_at_the_upper_border();
    const float diameters[] = {0.5f, 3, 60, 1e9f, 8589934080, 3e38f, INFINITY};
    const uint32_t sizes[][2] = {{1, 1}, {1, 7}, {7, 1}, {37, 23}};
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 7; i++) {
            uint32_t width = sizes[k][0], height = sizes[k][1], last = width * height - 1;
            const uint32_t corners[] = {0, width - 1, last - (width - 1), last};
            for (int c = 0; c < 4; c++) {
                picture p = sharp_picture(width, height);
                p.blur[corners[c]] = diameters[i];
                check_counts(&p);
            }
        }
}

static void every_pixel_counts_the_circles_that_reach_it(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 30; i++) {
        picture p = i % 2 ? sharp_picture(37, 23) : sharp_picture(23, 37);
        for (uint32_t k = 0; k < 37 * 23; k++)
            if (rk_case(i, k, 0, 1) % 64 <= i)
                p.blur[k] = exp2f(8 * unit_float(k, i) - 3);
        check_counts(&p);
    }
}

/* More circles than 16 bits count, with a sign, and as few as that takes: who marks pixel by pixel
 * marks half a billion. */
static void check_many_circles_in_a_pixel(void)
{
    enum { side = 182, pixels = side * side, middle = side / 2 };
    float *blur = malloc(pixels * sizeof *blur);
    int32_t *counts = malloc((side + 1) * (side + 1) * sizeof *counts);
    rk_check(blur && counts, "there is memory");
    for (int i = 0; i < pixels; i++)
        blur[i] = side;
    rk_lens_coc(blur, side, side, counts);
    int got = counts[middle * (side + 1) + middle];
    rk_check(got == pixels,
             "%d x %d circles that reach pixel (%d, %d): it got %d circles, want %d%s", side, side,
             middle, middle, got, pixels,
             rk_mistake_in_whole(got, pixels,
                                 RK_MISTAKES({(int16_t)pixels, "sums are kept in 16 bits"},
                                             {INT16_MAX, "sums are kept in 16 bits"})));
    free(counts);
    free(blur);
}

/* Circles in the first of two rows, and in the first of two columns; they reach the second, too. */
static void pictures_may_be_wider_or_higher_than_65536_pixels(void **state)
{
    (void)state;
    check_many_circles_in_a_pixel();
    enum { length = 1000001, at = 999000, reach = 2, large = 999100 };
    int32_t *counts = malloc((size_t)3 * (length + 1) * sizeof *counts);
    for (int upright = 0; upright < 2; upright++) {
        float *blur = calloc((size_t)2 * length, sizeof *blur);
        rk_check(blur && counts, "there is memory");
        size_t step = upright ? 2 : 1, stride = upright ? 3 : 1, beside = upright ? 1 : length + 1;
        blur[step * at] = 2 * reach;
        blur[0] = 2 * large;
        blur[step * 300] = 4294967040; /* as far as 32 bits go, with a sign and without */
        blur[step * large] = 8589934080;
        rk_lens_coc(blur, upright ? 2 : length, upright ? length : 2, counts);
        for (int i = 0; i < length; i++) {
            int got = counts[stride * (size_t)i], other = counts[stride * (size_t)i + beside];
            int want = (abs(i - at) <= reach) + (i <= large) + 2;
            rk_check(
                got == want && other == want,
                "two %s of %d pixels, in the first circles of diameter %d around pixel %d and of "
                "diameter %d around pixel 0, and two of 4294967040 and 8589934080 around pixels "
                "300 and %d: pixel %d got %d circles, the one beside it %d, want %d",
                upright ? "columns" : "rows", length, 2 * reach, at, 2 * large, large, i, got,
                other, want);
        }
        free(blur);
    }
    free(counts);
}

/* Processor time of the fastest of several runs, in seconds, with a circle around each pixel; of
 * the first that is fast enough, unless that is hopeless. A page has no clock of processor time,
 * and other programs may take most of a run's. */
static double seconds_of(uint32_t width, uint32_t height, float diameter, double enough)
{
    const int runs = enough > 0 ? 12 : 3;
    size_t pixels = (size_t)width * height, stride = (size_t)width + 1;
    float *blur = malloc(pixels * sizeof *blur);
    int32_t *counts = malloc(stride * (height + 1) * sizeof *counts);
    rk_check(blur && counts, "there is memory");
    for (size_t i = 0; i < pixels; i++)
        blur[i] = diameter;
    double fastest = INFINITY;
    for (int run = 0; run < runs && fastest > enough && (run < 3 || fastest < 20 * enough); run++) {
        double start = rk_clock_thread();
        rk_lens_coc(blur, width, height, counts);
        fastest = fmin(fastest, rk_clock_thread() - start);
    }
    int middle = counts[height / 2 * stride + width / 2];
    double side = 2 * ceil((double)diameter / 2) + 1;
    int want = (int)(fmin(side, width) * fmin(side, height));
    rk_check(middle == want,
             "%u x %u circles of diameter %g: the pixel in the middle got %d, want %d%s", width,
             height, (double)diameter, middle, want,
             want > UINT16_MAX ? ": more than 16 bits count" : "");
    free(counts);
    free(blur);
    return fastest;
}

/* Processor time of the fastest of several runs of the same work, in seconds: four numbers for each
 * pixel, then two sums. */
static double seconds_of_plain_loops(uint32_t width, uint32_t height)
{
    enum { runs = 3 };
    size_t stride = (size_t)width + 1, length = stride * (height + 1);
    volatile int32_t *counts = malloc(length * sizeof *counts);
    rk_check(counts, "there is memory");
    double fastest = INFINITY;
    for (int run = 0; run < runs; run++) {
        double start = rk_clock_thread();
        for (size_t i = 0; i < length; i++)
            counts[i] = 0;
        for (size_t i = 0; i + stride + 1 < length; i++) {
            counts[i]++, counts[i + 1]--;
            counts[i + stride]--, counts[i + stride + 1]++;
        }
        for (size_t i = 1; i < length; i++)
            counts[i] += counts[i - 1];
        for (size_t i = stride; i < length; i++)
            counts[i] += counts[i - stride];
        fastest = fmin(fastest, rk_clock_thread() - start);
    }
    free((void *)counts);
    return fastest;
}

static void large_circles_cost_no_more_than_small_ones(void **state)
{
    (void)state;
    /* Pixel by pixel large circles would take 1800 times as much or more; with numbers in each row,
     * or in each column, 4000 times as much in the picture that is long in this direction. */
    const uint32_t sizes[][2] = {{4, 16384}, {16384, 4}, {256, 256}};
    for (int i = 0; i < 3; i++) {
        uint32_t width = sizes[i][0], height = sizes[i][1];
        double plain = seconds_of_plain_loops(width, height),
               small = seconds_of(width, height, 1, 0);
        /* Sanitizers make it 5 to 8 times. */
        rk_check(
            small <= 100 * plain + 0.02,
            "%u x %u pixels: circles of diameter 1 take %.6f s; want at most 100 times the %.6f s "
            "of plain loops over as many numbers",
            width, height, small, plain);
        /* Equal apart from the processor's other work. Some systems count time in hundredths of a
         * second: allow two of these. */
        const float diameters[] = {1e3f, 1e6f}; /* by the first, slow ways fail soon */
        for (int k = 0; k < 2; k++) {
            double most = 10 * small + 0.02, large = seconds_of(width, height, diameters[k], most);
            rk_check(large <= most,
                     "%u x %u pixels: circles of diameter %g take %.6f s, circles of diameter 1 "
                     "%.6f s; want about the same: four numbers each, whatever the size",
                     width, height, (double)diameters[k], large, small);
        }
    }
}

/* Two additions per pixel, whatever the picture's shape. */
static void long_pictures_cost_no_more_than_square_ones(void **state)
{
    (void)state;
    /* With sums that begin anew for each pixel, long ones would take 64 times as much. */
    const uint32_t sizes[][2] = {{4, 16384}, {16384, 4}};
    double square = seconds_of(256, 256, 1, 0), most = 10 * square + 0.02;
    for (int i = 0; i < 2; i++) {
        double seconds = seconds_of(sizes[i][0], sizes[i][1], 1, most);
        rk_check(seconds <= most,
                 "%u x %u pixels take %.6f s, 256 x 256 as many, %.6f s; want about the same: a "
                 "sum continues the one before it",
                 sizes[i][0], sizes[i][1], seconds, square);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(known_points_of_the_square_have_known_points_on_the_disk),
    cmocka_unit_test(squares_become_circles),
    cmocka_unit_test(the_disk_is_covered_evenly),
    cmocka_unit_test(neighbours_in_the_square_are_neighbours_on_the_disk),
    cmocka_unit_test(rays_start_on_a_disk_in_the_cameras_own_axes),
    cmocka_unit_test(the_aperture_is_the_diameter_in_thousandths_of_a_unit),
    cmocka_unit_test(directions_are_unit_and_rays_have_no_end),
    cmocka_unit_test(a_ray_from_the_lens_centre_is_the_pinhole_ray_to_the_bit),
    cmocka_unit_test(rays_do_not_depend_on_the_cameras_place),
    cmocka_unit_test(with_aperture_0_every_ray_is_the_pinhole_ray_to_the_bit),
    cmocka_unit_test(rays_of_a_picture_point_converge_on_the_focal_plane),
    cmocka_unit_test(rays_of_a_picture_point_converge_on_the_focal_sphere),
    cmocka_unit_test(a_lens_focused_at_infinity_sends_parallel_rays),
    cmocka_unit_test(a_ray_depends_on_lens_view_picture_point_and_xi),
    cmocka_unit_test(rays_do_not_depend_on_the_unit_of_length),
    cmocka_unit_test(a_pinhole_has_no_circles_of_confusion),
    cmocka_unit_test(a_point_in_focus_has_no_circle_of_confusion),
    cmocka_unit_test(the_circle_of_confusion_equals_the_closed_form),
    cmocka_unit_test(a_focal_plane_uses_depth_and_a_sphere_distance),
    cmocka_unit_test(a_circle_depends_on_lens_view_ray_and_distance),
    cmocka_unit_test(circles_do_not_depend_on_the_unit_of_length),
    cmocka_unit_test(the_circle_of_an_infinitely_far_point_is_finite),
    cmocka_unit_test(a_lens_focused_at_infinity_blurs_what_is_near),
    cmocka_unit_test(the_rim_of_the_lens_draws_the_rim_of_the_circle),
    cmocka_unit_test(a_circle_reaches_every_pixel_that_it_may_touch),
    cmocka_unit_test(circles_below_half_a_pixel_are_points),
    cmocka_unit_test(circles_end_at_the_border_of_the_picture),
    cmocka_unit_test(every_pixel_counts_the_circles_that_reach_it),
    cmocka_unit_test(pictures_may_be_wider_or_higher_than_65536_pixels),
    cmocka_unit_test(large_circles_cost_no_more_than_small_ones),
    cmocka_unit_test(long_pictures_cost_no_more_than_square_ones),
};

RK_SUITE("depth_of_field", tests)
