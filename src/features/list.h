/* Written by tools/features.sh from assignments/features.tsv. */
/* clang-format off */
/* For programs that define RK_FEATURE. */
#ifdef RK_FEATURE
RK_FEATURE(bvh_median)
RK_FEATURE(sah_binning)
RK_FEATURE(shading)
RK_FEATURE(parallelogram_light)
RK_FEATURE(transparency)
RK_FEATURE(bloom)
RK_FEATURE(glossy_reflection)
RK_FEATURE(cubemap)
RK_FEATURE(depth_of_field)
RK_FEATURE(motion_blur)
#endif
