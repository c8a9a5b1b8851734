/* Pictures against a reference, for tables of error against time. */
#ifndef RK_RENDER_CONVERGE_H
#define RK_RENDER_CONVERGE_H

#include "base/image.h"
#include "base/table.h"

/* Fills in the row's errors: of all channels of all pixels alike. The pictures have one size. */
void rk_converge_compare(rk_convergence_row *row, const rk_image *got, const rk_image *want);

#endif
