/* Pictures of six faces are copied by tables of cells; longitude and latitude are looked up for
 * each texel of the cube. */
#include "io/environment_file.h"

#include "io/image_file.h"
#include "io/image_world.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* Every path here is shorter; longer ones are refused. */
typedef struct long_path {
    char text[4096];
} long_path;

/* --- faces in one picture --------------------------------------------------------------------- */

/* The place of a face, in columns and rows of faces. */
typedef struct cell {
    rk_cube_face face;
    uint8_t column, row;
    bool upside_down;
} cell;

typedef struct layout {
    uint8_t columns, rows;
    cell cells[RK_FACES];
} layout;

/* Strips in OpenGL's order, in which +z is ahead; see the header. */
static const layout layouts[] = {
    {4,
     3,
     {{RK_FACE_Y, 1, 0, false},
      {RK_FACE_MINUS_X, 0, 1, false},
      {RK_FACE_MINUS_Z, 1, 1, false},
      {RK_FACE_X, 2, 1, false},
      {RK_FACE_Z, 3, 1, false},
      {RK_FACE_MINUS_Y, 1, 2, false}}},
    {3,
     4,
     {{RK_FACE_Y, 1, 0, false},
      {RK_FACE_MINUS_X, 0, 1, false},
      {RK_FACE_MINUS_Z, 1, 1, false},
      {RK_FACE_X, 2, 1, false},
      {RK_FACE_MINUS_Y, 1, 2, false},
      {RK_FACE_Z, 1, 3, true}}},
    {6,
     1,
     {{RK_FACE_X, 0, 0, false},
      {RK_FACE_MINUS_X, 1, 0, false},
      {RK_FACE_Y, 2, 0, false},
      {RK_FACE_MINUS_Y, 3, 0, false},
      {RK_FACE_MINUS_Z, 4, 0, false},
      {RK_FACE_Z, 5, 0, false}}},
    {1,
     6,
     {{RK_FACE_X, 0, 0, false},
      {RK_FACE_MINUS_X, 0, 1, false},
      {RK_FACE_Y, 0, 2, false},
      {RK_FACE_MINUS_Y, 0, 3, false},
      {RK_FACE_MINUS_Z, 0, 4, false},
      {RK_FACE_Z, 0, 5, false}}},
};

static void copy_cell(rk_cubemap *map, const rk_image *image, const cell *from)
{
    uint32_t side = map->side, last = side - 1;
    for (uint32_t row = 0; row < side; row++)
        for (uint32_t column = 0; column < side; column++) {
            uint32_t x = from->upside_down ? last - column : column;
            uint32_t y = from->upside_down ? last - row : row;
            *rk_cubemap_texel(map, from->face, column, row) =
                *rk_image_at(image, (size_t)from->column * side + x, (size_t)from->row * side + y);
        }
}

/* Calls rk_cubemap_init, with the file's name in the error. */
static bool make_map(rk_cubemap *map, size_t side, const char *path, rk_error *error)
{
    if (side > RK_CUBEMAP_SIDE_MAX)
        return rk_fail(error, "%.800s: faces of %zu texels per side: reduce them to %d at most",
                       path, side, RK_CUBEMAP_SIDE_MAX);
    return rk_cubemap_init(map, (uint32_t)side, error);
}

static bool unfold(rk_cubemap *map, const rk_image *image, const layout *l, const char *path,
                   rk_error *error)
{
    if (!make_map(map, image->width / l->columns, path, error))
        return false;
    for (int i = 0; i < RK_FACES; i++)
        copy_cell(map, image, &l->cells[i]);
    return true;
}

/* --- longitude and latitude ------------------------------------------------------------------- */

/* Longitudes wrap around; beyond a pole, the picture continues on the opposite longitude. */
static rk_vec3 world_pixel(const rk_image *world, long x, long y)
{
    const long width = (long)world->width, height = (long)world->height;
    if (y < 0 || y >= height) {
        x += width / 2;
        y = y < 0 ? 0 : height - 1;
    }
    return *rk_image_at(world, (size_t)((x + width) % width), (size_t)y);
}

static rk_vec3 world_at(const rk_image *world, rk_vec3 direction)
{
    float longitude = atan2f(direction.x, -direction.z); /* from -z, to the right */
    float from_top = atan2f(hypotf(direction.x, direction.z), direction.y);
    float x = (0.5f + longitude / (2 * RK_PI)) * (float)world->width - 0.5f;
    float y = from_top / RK_PI * (float)world->height - 0.5f;
    float left = floorf(x), above = floorf(y);
    long i = (long)left, j = (long)above;
    rk_vec3 upper = rk_mix(world_pixel(world, i, j), world_pixel(world, i + 1, j), x - left);
    rk_vec3 lower =
        rk_mix(world_pixel(world, i, j + 1), world_pixel(world, i + 1, j + 1), x - left);
    return rk_mix(upper, lower, y - above);
}

/* A face's texels are largest in its middle: 2 / side. There they should match a pixel on the
 * equator, 2 pi / width. */
static size_t side_for_world(const rk_image *world)
{
    size_t side = (size_t)ceil((double)world->width / (double)RK_PI);
    return side < RK_CUBEMAP_SIDE_MAX ? side : RK_CUBEMAP_SIDE_MAX;
}

static bool convert_world(rk_cubemap *map, const rk_image *world, const char *path, rk_error *error)
{
    if (!make_map(map, side_for_world(world), path, error))
        return false;
    for (int face = 0; face < RK_FACES; face++)
        for (uint32_t row = 0; row < map->side; row++)
            for (uint32_t column = 0; column < map->side; column++)
                *rk_cubemap_texel(map, (rk_cube_face)face, column, row) = world_at(
                    world, rk_cubemap_texel_direction(map->side, (rk_cube_face)face, column, row));
    return true;
}

/* --- one file --------------------------------------------------------------------------------- */

static bool convert(rk_cubemap *map, const rk_image *image, const char *path, rk_error *error)
{
    for (size_t i = 0; i < sizeof layouts / sizeof *layouts; i++)
        if (rk_image_shape_has_cells(image->width, image->height, layouts[i].columns,
                                     layouts[i].rows))
            return unfold(map, image, &layouts[i], path, error);
    return convert_world(map, image, path, error);
}

/* In place; pictures that raykit-image has read are small already. */
static void reduce_world(rk_image *world, size_t least_width)
{
    const size_t width = world->width, height = world->height;
    const size_t factor = rk_image_world_factor(width, height, least_width);
    double shares[4096];
    if (factor == 1 || factor > sizeof shares / sizeof *shares ||
        !rk_image_shape_has_world(width, height))
        return;
    float *pixels = &world->pixels->x;
    for (size_t y = 0; y < height / factor; y++) {
        rk_image_world_shares(shares, factor, y * factor, height);
        rk_image_world_average(pixels + 3 * y * (width / factor), pixels + 3 * y * factor * width,
                               width, factor, shares);
    }
    world->width = width / factor;
    world->height = height / factor;
}

static bool read_one(rk_cubemap *map, const char *path, uint32_t least_side, rk_error *error)
{
    rk_image image;
    const rk_image_file_wish wish = {.most_pixels = RK_ENVIRONMENT_FILE_PIXELS_MAX,
                                     .shape = RK_IMAGE_ENVIRONMENT,
                                     .least_width =
                                         (size_t)ceil((double)least_side * (double)RK_PI)};
    if (!rk_image_file_read_wished(&image, path, &wish, error))
        return false;
    reduce_world(&image, wish.least_width);
    bool ok = convert(map, &image, path, error);
    rk_image_free(&image);
    return ok;
}

/* --- six files -------------------------------------------------------------------------------- */

static const rk_cube_face order[RK_FACES] = {RK_FACE_X,       RK_FACE_MINUS_X, RK_FACE_Y,
                                             RK_FACE_MINUS_Y, RK_FACE_MINUS_Z, RK_FACE_Z};

/* Each row in this order: of OpenGL, of its enumerators, of pages and engines. The last is that of
 * Quake and its successors (st_to_vec in Quake II's gl_warp.c), whose yaw 0 looks at rt: ft is to
 * its right, lf behind, bk to the left; the edges of up and dn that touch rt are up's lowest and
 * dn's highest. */
typedef const char *const face_names[RK_FACES];
static face_names names[] = {
    {"px", "nx", "py", "ny", "pz", "nz"},
    {"posx", "negx", "posy", "negy", "posz", "negz"},
    {"pos_x", "neg_x", "pos_y", "neg_y", "pos_z", "neg_z"},
    {"+x", "-x", "+y", "-y", "+z", "-z"},
    {"x+", "x-", "y+", "y-", "z+", "z-"},
    {"xp", "xn", "yp", "yn", "zp", "zn"},
    {"xpos", "xneg", "ypos", "yneg", "zpos", "zneg"},
    {"positivex", "negativex", "positivey", "negativey", "positivez", "negativez"},
    {"positive_x", "negative_x", "positive_y", "negative_y", "positive_z", "negative_z"},
    {"right", "left", "top", "bottom", "front", "back"},
    {"right", "left", "up", "down", "front", "back"},
    {"r", "l", "u", "d", "f", "b"},
    {"rt", "lf", "up", "dn", "fr", "bk"},
    {"0", "1", "2", "3", "4", "5"},
    {"ft", "bk", "up", "dn", "rt", "lf"},
};

static bool fits(const rk_image *image, const rk_cubemap *map, const char *path, rk_error *error)
{
    if (map->side > 0 && image->width != map->side)
        return rk_fail(error,
                       "%.700s: has %zu x %zu pixels, but the first face has %u x %u: make all "
                       "six the same size",
                       path, image->width, image->height, map->side, map->side);
    return true;
}

/* The first face decides the size of all. */
static bool read_face(rk_cubemap *map, rk_cube_face face, const char *path,
                      rk_image_file_reader *reader, rk_error *error)
{
    rk_image image;
    const rk_image_file_wish wish = {
        .most_pixels = RK_ENVIRONMENT_FILE_PIXELS_MAX, .shape = RK_IMAGE_SQUARE, .reader = reader};
    if (!rk_image_file_read_wished(&image, path, &wish, error))
        return false;
    bool ok = fits(&image, map, path, error) &&
              (map->side > 0 || make_map(map, image.width, path, error));
    if (ok)
        copy_cell(map, &image, &(cell){.face = face});
    rk_image_free(&image);
    return ok;
}

/* Replaces the pattern's %s. */
static bool name_in_pattern(long_path *path, const char *pattern, const char *name, rk_error *error)
{
    const char *hole = strstr(pattern, "%s");
    if (strstr(hole + 2, "%s"))
        return rk_fail(
            error,
            "%.800s: has more than one %%s: leave the one that stands for px, nx, py, ny, pz, nz",
            pattern);
    int length = snprintf(path->text, sizeof path->text, "%.*s%s%s", (int)(hole - pattern), pattern,
                          name, hole + 2);
    return (length >= 0 && (size_t)length < sizeof path->text) ||
           rk_fail(error, "%.800s: the name is too long: give a shorter one", pattern);
}

/* Is the file's name, without its ending, this one, or does it end with it after one of _-. and a
 * blank? */
static bool is_named(const char *file, const char *name, bool at_end)
{
    const char *dot = strrchr(file, '.');
    size_t length = strlen(name), stem = dot ? (size_t)(dot - file) : 0;
    if (at_end ? stem <= length || !strchr("_-. ", file[stem - length - 1]) : stem != length)
        return false;
    return strncasecmp(dot - length, name, length) == 0;
}

/* Returns how many files have the name, of which the path is one; -1 if it is too long. */
static int count_in_folder(long_path *path, const char *folder, const char *name, bool at_end)
{
    DIR *directory = opendir(folder);
    int found = 0;
    for (struct dirent *entry; directory && found >= 0 && (entry = readdir(directory));)
        if (is_named(entry->d_name, name, at_end)) {
            int length = snprintf(path->text, sizeof path->text, "%s/%s", folder, entry->d_name);
            found = length >= 0 && (size_t)length < sizeof path->text ? found + 1 : -1;
        }
    if (directory)
        closedir(directory);
    return found;
}

static bool name_in_folder(long_path *path, const char *folder, const char *name, rk_error *error)
{
    int found = count_in_folder(path, folder, name, false);
    if (found == 0)
        found = count_in_folder(path, folder, name, true);
    if (found < 0)
        return rk_fail(error, "%.800s: the name is too long: give a shorter one", folder);
    return found == 1 ||
           rk_fail(error,
                   "%.700s: holds %s picture %s.*: name the faces of an environment px, nx, py, "
                   "ny, pz, nz (or posx ..., right, left ...), each in one file",
                   folder, found ? "more than one" : "no", name);
}

typedef bool find_face(long_path *path, const char *where, const char *name, rk_error *error);

/* The row of which most files are there; the first if none is. */
static face_names *choose_names(const char *where, find_face *find)
{
    face_names *best = &names[0];
    int most = 0;
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        int there = 0;
        for (int i = 0; i < RK_FACES; i++) {
            long_path path;
            struct stat status;
            there += find(&path, where, names[k][i], NULL) && stat(path.text, &status) == 0;
        }
        if (there > most)
            most = there, best = &names[k];
    }
    return best;
}

static bool read_six(rk_cubemap *map, const char *where, find_face *find, rk_error *error)
{
    long_path paths[RK_FACES]; /* find all before reading the first, which may be slow */
    face_names *chosen = choose_names(where, find);
    for (int i = 0; i < RK_FACES; i++)
        if (!find(&paths[i], where, (*chosen)[i], error))
            return false;
    rk_image_file_reader reader = {0};
    bool ok = true;
    for (int i = 0; i < RK_FACES && ok; i++)
        ok = read_face(map, order[i], paths[i].text, &reader, error);
    rk_image_file_reader_end(&reader);
    if (!ok)
        rk_cubemap_free(map);
    return ok;
}

bool rk_environment_file_read(rk_cubemap *map, const char *path, rk_error *error)
{
    return rk_environment_file_read_for(map, path, 0, error);
}

bool rk_environment_file_read_for(rk_cubemap *map, const char *path, uint32_t least_side,
                                  rk_error *error)
{
    struct stat status;
    *map = (rk_cubemap){0};
    if (strstr(path, "%s"))
        return read_six(map, path, name_in_pattern, error);
    if (stat(path, &status) == 0 && S_ISDIR(status.st_mode))
        return read_six(map, path, name_in_folder, error);
    return read_one(map, path, least_side, error);
}
