/* A mesh from a file, before the camera: turned so that its front faces the viewer, and scaled so
 * that it fills two thirds of the picture, whatever its units.
 *
 * A file's front is +z, as glTF has it and most programs export; up is +y, or z in scans and CAD,
 * whose front is -y. The default camera stands at -z, so the mesh makes half a turn about y. A few
 * triangles far from all others would make these a speck: where nine tenths of the triangles lie in
 * a tenth of the extent, the frame is theirs. */
#ifndef RK_SCENE_FRAMING_H
#define RK_SCENE_FRAMING_H

#include "scene/scene.h"

typedef enum rk_up {
    RK_UP_X,
    RK_UP_Y,
    RK_UP_Z,
    RK_UP_OF_FILE /* the axis that the file names, else y */
} rk_up;

typedef enum rk_front {
    RK_FRONT_USUAL, /* -y where z is up, else z */
    RK_FRONT_X,
    RK_FRONT_Y,
    RK_FRONT_Z,
    RK_FRONT_MINUS_X,
    RK_FRONT_MINUS_Y,
    RK_FRONT_MINUS_Z
} rk_front;

typedef struct rk_framing {
    uint32_t up;          /* an rk_up: the axis of the file that points up */
    uint32_t front;       /* an rk_front: the axis towards the viewer; another one than up */
    rk_vec3 rotation;     /* of the camera, as in rk_camera */
    size_t width, height; /* of the picture, or of any with the same shape */
} rk_framing;

/* Up is the file's, the front the usual one, the camera is the default one, the picture is square.
 */
rk_framing rk_framing_default(void);

/* The triangles for which the frame was chosen. */
typedef struct rk_framed {
    uint32_t triangles; /* all of them, or nine tenths and more */
    double extent; /* longest side of the bounds of these / of all triangles; 1 if these are all */
} rk_framed;

/* Turns positions and normals: up, an axis, becomes +y, the front -z. Exact. */
void rk_mesh_face_viewer(rk_mesh *mesh, rk_up up, rk_front front);

/* Whether the two are the same axis of the file. */
bool rk_front_is_up(rk_front front, rk_up up);

/* Moves and scales the mesh: in the picture of the camera the framed triangles' bounds are in the
 * middle and fill two thirds of the width or of the height, and along the view their middle is at
 * the camera's target. A mesh that is long along the view is smaller: it stays away from the camera
 * by half of its distance. A mesh of one point is only moved. Computed in double. Requires a valid
 * mesh; false when memory is short. */
bool rk_mesh_frame(rk_mesh *mesh, const rk_camera *camera, size_t width, size_t height,
                   rk_framed *framed, rk_error *error);

/* Like rk_scene_around, but the mesh faces the viewer and is framed; the light stays with the
 * camera, above it and to its left, so that no side of the mesh is dark. */
bool rk_scene_framed(rk_scene *scene, const char *name, rk_mesh *mesh, const rk_framing *framing,
                     rk_framed *framed, rk_error *error);

#endif
