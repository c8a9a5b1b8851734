/* raykit, all of it: include this one header, or just those that you need. */
#ifndef RAYKIT_H
#define RAYKIT_H

#include "base/image.h"
#include "base/parallel.h"
#include "scene/bvh.h"
#include "scene/camera.h"
#include "scene/mesh.h"
#include "scene/scene.h"

#endif
