/* Tidy tables: CSV files (RFC 4180) in which each row is one measurement. */
#ifndef RK_BASE_TABLE_H
#define RK_BASE_TABLE_H

#include "base/error.h"

/* Puts a row into the file at `path`, creating it with `header` if missing. A row with the same
 * first `key_columns` cells is replaced, so that measuring again updates the table. Cells are
 * quoted where necessary. A file with another header is an error and stays unchanged. The file is
 * replaced whole or not at all; of callers in several threads or processes each keeps its row. */
bool rk_table_put(const char *path, const char *const *header, const char *const *cells,
                  size_t columns, size_t key_columns, rk_error *error);

/* A timing row's statistics. */
typedef struct rk_timing {
    double median, min, max;
    unsigned runs;
} rk_timing;

enum { RK_RUNS_MAX = 1000 };

/* Statistics of 1 to RK_RUNS_MAX figures, which it sorts. The median of an even number of figures
 * is the mean of the middle two. */
rk_timing rk_timing_of(double *figures, unsigned runs);

/* Puts a row under feature,scene,triangles,method,isa,threads,metric,unit,median,min,max,runs; the
 * columns up to `unit` are the key. */
typedef struct rk_timing_row {
    const char *feature, *scene;
    unsigned long triangles;
    const char *method, *isa;
    unsigned threads;
    const char *metric, *unit;
    rk_timing timing;
} rk_timing_row;

bool rk_table_put_timing(const char *path, const rk_timing_row *row, rk_error *error);

/* Puts a row with the error of a method and the time that it took under
 * feature,scene,method,samples,seconds,rmse,max_error,bias,reference; the columns up to `samples`
 * are the key. */
typedef struct rk_convergence_row {
    const char *feature, *scene, *method;
    unsigned long samples;
    double seconds, rays;             /* of one picture; rays per pixel */
    double rmse, rmse_low, rmse_high; /* over all seeds, the least and the largest of one */
    double max_error, bias;           /* errors: in the unit of the measured quantity */
    const char *reference;            /* source of the true values, such as "closed form" */
    unsigned long seeds;              /* pictures */
} rk_convergence_row;

bool rk_table_put_convergence(const char *path, const rk_convergence_row *row, rk_error *error);

/* Seconds on the monotonic clock, and seconds of processor time of the calling thread. The C
 * library's clock() advances by ticks of milliseconds where a limit of processor time is set; this
 * one does not. */
double rk_clock_wall(void);
double rk_clock_thread(void);

#endif
