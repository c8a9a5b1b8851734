/* --mpi: the processes that mpirun has started render one picture. The library and the drivers need
 * no MPI: raykit-mpi.so, which configure builds where it finds MPI, is loaded by this option alone;
 * not installed. */
#ifndef RK_DRIVER_DRIVER_TEAM_H
#define RK_DRIVER_DRIVER_TEAM_H

#include "driver/driver_main.h"

/* Joins the team if --mpi is among the arguments, before they are read, so that what is wrong with
 * them is said once. Processes other than 0 are silent from then on. */
bool rk_driver_join_team(rk_driver *driver, int argc, char **argv, rk_error *error);

/* Is there no team, or is this its process 0, which alone prints and writes? */
bool rk_driver_speaks(const rk_driver *driver);

/* Refuses what a team does not do: debug views, explained pixels, tables. */
bool rk_driver_check_team(const rk_driver *driver, const rk_driver_spec *spec, rk_error *error);

/* After scene and tree are made, or `ok` is false: do all processes have them, and are these,
 * version and options the same? If not, all get the same error. Renderings by the driver's pool are
 * then shared. */
bool rk_driver_agree(rk_driver *driver, bool ok, rk_error *error);

/* No further rendering is shared. */
void rk_driver_leave_team(rk_driver *driver);

/* Prints an error, unless process 0 does it for all; returns false. */
bool rk_driver_tell(const rk_driver *driver, const char *text);

/* Ends this process's part, of all processes if the others may wait for it. */
void rk_driver_end_team(rk_driver *driver, bool ok);

#endif
