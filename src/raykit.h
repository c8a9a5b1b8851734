/* All of raykit: include this header, or only those that you need. */
#ifndef RAYKIT_H
#define RAYKIT_H

#include "base/image.h"
#include "base/parallel.h"
#include "features/all.h"
#include "io/environment_file.h"
#include "io/image_file.h"
#include "io/mesh_file.h"
#include "io/png.h"
#include "post/bloom_stage.h"
#include "render/render.h"
#include "scene/framing.h"
#include "scene/scene.h"
#include "scenes/builtin.h"
#include "scenes/sky.h"

#endif
