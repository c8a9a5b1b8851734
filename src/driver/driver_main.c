/* One order for all drivers: options, scene, tree, then a study, a debug view, rows of times or the
 * picture. */
#include "driver/driver_main.h"

#include "driver/driver_options.h"
#include "driver/driver_team.h"

static const rk_driver_view *find_view(const rk_driver_spec *spec, const rk_driver *driver)
{
    for (const rk_driver_view *view = spec->views; view && view->name; view++)
        if (rk_driver_debug(driver, view->name))
            return view;
    return NULL;
}

static const rk_driver_study *find_study(const rk_driver_spec *spec)
{
    for (const rk_driver_study *study = spec->studies; study && study->wanted; study++)
        if (*study->wanted)
            return study;
    return NULL;
}

/* A driver may leave a step out. */
static bool run_step(rk_driver_step *step, rk_driver *driver, rk_error *error)
{
    return !step || step(driver, error);
}

static bool save(const rk_driver_spec *spec, rk_driver *driver, rk_error *error)
{
    return spec->save ? spec->save(driver, error) : rk_driver_save(driver, NULL, error);
}

static bool build(const rk_driver_spec *spec, rk_driver *driver, rk_error *error)
{
    const rk_driver_study *study = find_study(spec);
    const rk_driver_view *view = study ? NULL : find_view(spec, driver);
    const bool without_tree = (study && study->without_tree) || (view && view->without_tree);
    return run_step(spec->choose, driver, error) && run_step(spec->prepare, driver, error) &&
           (without_tree ||
            (rk_driver_build(driver, error) && run_step(spec->check_tree, driver, error)));
}

bool rk_driver_begin_again(const rk_driver_spec *spec, rk_driver *driver, rk_error *error)
{
    rk_driver_aim(driver);
    return rk_image_init(&driver->image, driver->render.width, driver->render.height, error) &&
           run_step(spec->choose, driver, error) && run_step(spec->check_tree, driver, error);
}

rk_options_result rk_driver_begin(const rk_driver_spec *spec, rk_driver *driver, int argc,
                                  char **argv, rk_error *error)
{
    *driver = rk_driver_default(spec->feature, spec->summary);
    rk_driver_set_defaults(driver, spec);
    if (!rk_driver_join_team(driver, argc, argv, error))
        return RK_OPTIONS_BAD;
    const rk_options_result result = rk_driver_read_options(driver, spec, argc, argv, error);
    driver->quiet = driver->quiet || !rk_driver_speaks(driver);
    if (result == RK_OPTIONS_OK && !(rk_driver_start(driver, error) && build(spec, driver, error)))
        return RK_OPTIONS_BAD;
    return result;
}

bool rk_driver_draw(const rk_driver_spec *spec, rk_driver *driver, rk_error *error)
{
    const rk_driver_study *study = find_study(spec);
    const rk_driver_view *view = find_view(spec, driver);
    if (study)
        return study->put(driver, error);
    if (view)
        return view->draw(driver, error) && save(spec, driver, error);
    rk_driver_note_unused(driver);
    if (!rk_driver_render(driver, error))
        return false;
    rk_driver_leave_team(driver);
    if (!rk_driver_speaks(driver))
        return true;
    return driver->timing ? run_step(spec->put_rows, driver, error) : save(spec, driver, error);
}

int rk_driver_main(const rk_driver_spec *spec, int argc, char **argv)
{
    rk_error error = {""};
    rk_driver driver;
    const rk_options_result result = rk_driver_begin(spec, &driver, argc, argv, &error);
    const bool ok = rk_driver_agree(&driver, result != RK_OPTIONS_BAD, &error) &&
                    (result == RK_OPTIONS_DONE || rk_driver_draw(spec, &driver, &error));
    return rk_driver_finish(&driver, ok, &error);
}
