/* In double precision: nodes may scale far up and down again. */
#include "io/mesh_helper/mesh_place.h"

#include <math.h>

rk_mesh_place rk_mesh_place_in(const rk_mesh_place *parent, const struct aiMatrix4x4 *t)
{
    const double child[3][4] = {
        {(double)t->a1, (double)t->a2, (double)t->a3, (double)t->a4},
        {(double)t->b1, (double)t->b2, (double)t->b3, (double)t->b4},
        {(double)t->c1, (double)t->c2, (double)t->c3, (double)t->c4},
    };
    rk_mesh_place result = {.is_identity = true};
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++) {
            double sum = column == 3 ? parent->m[row][3] : 0;
            for (int k = 0; k < 3; k++)
                sum += parent->m[row][k] * child[k][column];
            result.m[row][column] = sum;
            result.is_identity &= sum == (row == column ? 1 : 0);
        }
    return result;
}

rk_vec3 rk_mesh_place_point(const rk_mesh_place *p, rk_vec3 v)
{
    if (p->is_identity)
        return v;
    double x = (double)v.x, y = (double)v.y, z = (double)v.z, moved[3];
    for (int i = 0; i < 3; i++)
        moved[i] = p->m[i][0] * x + p->m[i][1] * y + p->m[i][2] * z + p->m[i][3];
    return rk_vec((float)moved[0], (float)moved[1], (float)moved[2]);
}

/* Normals are transformed by the inverse transpose. The cofactors equal it up to a positive factor,
 * once multiplied by the determinant's sign, and exist for singular transforms, too. */
static void cofactors(const rk_mesh_place *p, double c[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            c[i][k] = p->m[i1][k1] * p->m[i2][k2] - p->m[i1][k2] * p->m[i2][k1];
        }
    double determinant = p->m[0][0] * c[0][0] + p->m[0][1] * c[0][1] + p->m[0][2] * c[0][2];
    for (int i = 0; i < 3 && determinant < 0; i++)
        for (int k = 0; k < 3; k++)
            c[i][k] = -c[i][k];
}

/* False for a vector without direction. */
static bool make_unit(const double v[3], rk_vec3 *unit)
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 0 && isfinite(length)))
        return false;
    *unit = rk_vec((float)(v[0] / length), (float)(v[1] / length), (float)(v[2] / length));
    return true;
}

bool rk_mesh_place_normal(const rk_mesh_place *p, const struct aiVector3D *n, rk_vec3 *moved)
{
    double v[3] = {(double)n->x, (double)n->y, (double)n->z};
    if (p->is_identity)
        return make_unit(v, moved);
    double c[3][3], w[3];
    cofactors(p, c);
    for (int i = 0; i < 3; i++)
        w[i] = c[i][0] * v[0] + c[i][1] * v[1] + c[i][2] * v[2];
    return make_unit(w, moved);
}

rk_vec3 rk_mesh_place_face_normal(rk_vec3 a, rk_vec3 b, rk_vec3 c)
{
    double e[3] = {(double)b.x - (double)a.x, (double)b.y - (double)a.y, (double)b.z - (double)a.z};
    double f[3] = {(double)c.x - (double)a.x, (double)c.y - (double)a.y, (double)c.z - (double)a.z};
    double n[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
    rk_vec3 unit = rk_vec(0, 0, 1);
    make_unit(n, &unit);
    return unit;
}
