/* Film stage: from a tile's sums to pixels of the picture; not installed. */
#ifndef RK_RENDER_STAGES_FILM_STAGE_H
#define RK_RENDER_STAGES_FILM_STAGE_H

#include "base/image.h"
#include "render/film.h"
#include "render/rendering.h"
#include "render/sample_pass.h"

/* Divides the sums of the pass's pixels by its number of samples. */
void rk_film_mean(const rk_rendering *r, const rk_sample_pass *pass, rk_film *film);

/* Writes the tile's part of the picture. */
void rk_film_stage(const rk_tile *tile, const rk_film *film, rk_image *image);

#endif
