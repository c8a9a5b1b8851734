/* The tiles of a picture: squares of RK_TILE_SIDE pixels, clipped at the right and the bottom;
 * not installed. */
#ifndef RK_RENDER_TILES_H
#define RK_RENDER_TILES_H

#include "render/plan.h"
#include "render/sample_pass.h"

static inline uint32_t rk_tiles_along(uint32_t pixels)
{
    return (pixels + RK_TILE_SIDE - 1) / RK_TILE_SIDE;
}

static inline uint32_t rk_tile_count(const rk_render_options *options)
{
    return rk_tiles_along(options->width) * rk_tiles_along(options->height);
}

static inline rk_tile rk_tile_at(const rk_render_options *options, uint32_t index)
{
    uint32_t across = rk_tiles_along(options->width);
    uint32_t x = index % across * RK_TILE_SIDE, y = index / across * RK_TILE_SIDE;
    uint32_t right = options->width - x, below = options->height - y;
    return (rk_tile){x, y, right < RK_TILE_SIDE ? right : RK_TILE_SIDE,
                     below < RK_TILE_SIDE ? below : RK_TILE_SIDE};
}

#endif
