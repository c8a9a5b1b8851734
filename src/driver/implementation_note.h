/* The linked units: their authors, for captions, and which of them are still starters. */
#ifndef RK_DRIVER_IMPLEMENTATION_NOTE_H
#define RK_DRIVER_IMPLEMENTATION_NOTE_H

/* Empty if all units are the kit's own; else "units: mine (bvh_median), others: the kit's". It is
 * in an object file of its own, which drivers that are linked with other units replace. */
extern const char rk_implementation_note[];

/* The same for each unit that is not the kit's own; ends with a stem NULL. */
typedef struct rk_implementation_author {
    const char *stem, *author;
} rk_implementation_author;
extern const rk_implementation_author rk_implementation_authors[];

/* What the other units are: "the kit's"; empty if there are none. */
extern const char rk_implementation_others[];

/* The default of --out, likewise: pictures by other units do not replace those by the kit's own. */
extern const char rk_pictures_folder[];

/* The features whose units are still the starters, each between blanks: " shading bloom ". */
extern const char rk_unsolved_features[];

#endif
