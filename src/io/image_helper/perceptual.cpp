// Yee's metric in three steps: the threshold of visible luminance differences at this brightness;
// the factor by which busy surroundings raise it; and, where luminance passes, the difference in
// hue.
//
// OpenImageIO has the metric too, but its luminance test reads a channel that does not exist
// (2.4.7, compare_Yee) and so accepts black for white. Its bands are also blurred by one fixed
// kernel; here the distance of the kernel's taps doubles with each level (Burt and Adelson 1983),
// so that each band has the frequency that the formulas assume.
#include "io/image_helper/perceptual.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace {

constexpr double degrees_wide = 45;
constexpr double white = 100; // candela per square metre
constexpr size_t levels = 8, bands = levels - 2;
constexpr double least_luminance = 1e-5; // candela per square metre: far below what an eye can see

using Plane = std::vector<float>;

struct View {
    std::array<Plane, levels> luminance; // blurred more with each level
    Plane a, b;                          // hue, in CIELAB
};

// --- eyes ---------------------------------------------------------------------------------------

// Sensitivity to contrast at a frequency in cycles per degree (Barten 1989).
double contrast_sensitivity(double frequency, double luminance)
{
    double a = 440 * std::pow(1 + 0.7 / luminance, -0.2);
    double b = 0.3 * std::pow(1 + 100 / luminance, 0.15);
    return a * frequency * std::exp(-b * frequency) * std::sqrt(1 + 0.06 * std::exp(b * frequency));
}

// The factor by which existing contrast raises the threshold (Daly 1993).
double masking(double contrast)
{
    return std::pow(1 + std::pow(0.0153 * std::pow(392.498 * contrast, 0.7), 4), 0.25);
}

// The smallest visible difference for an eye adapted to a luminance (Ward Larson et al. 1997).
double threshold(double luminance)
{
    double l = std::log10(luminance), t;
    if (l < -3.94)
        t = -2.86;
    else if (l < -1.44)
        t = std::pow(0.405 * l + 1.6, 2.18) - 2.86;
    else if (l < -0.0184)
        t = l - 0.395;
    else if (l < 1.9)
        t = std::pow(0.249 * l + 0.65, 2.7) - 0.72;
    else
        t = l - 1.255;
    return std::pow(10, t);
}

// --- views --------------------------------------------------------------------------------------

// Five taps along one axis, `step` samples apart; the edge is repeated.
Plane blur_axis(const Plane &source, size_t width, size_t height, long step, bool along_x)
{
    static const float weights[] = {0.05f, 0.25f, 0.4f, 0.25f, 0.05f};
    Plane result(source.size());
    long last_x = long(width) - 1, last_y = long(height) - 1;
    for (long y = 0; y <= last_y; y++)
        for (long x = 0; x <= last_x; x++) {
            float sum = 0;
            for (int k = 0; k < 5; k++) {
                long sx = along_x ? std::clamp(x + (k - 2) * step, 0L, last_x) : x;
                long sy = along_x ? y : std::clamp(y + (k - 2) * step, 0L, last_y);
                sum += weights[k] * source[size_t(sy) * width + size_t(sx)];
            }
            result[size_t(y) * width + size_t(x)] = sum;
        }
    return result;
}

// CIELAB's compressed ratio to white (CIE 15:2004).
double compress(double ratio)
{
    return ratio > 216.0 / 24389 ? std::cbrt(ratio) : (24389.0 / 27 * ratio + 16) / 116;
}

View make_view(const float *rgb, size_t width, size_t height)
{
    size_t count = width * height;
    View view;
    view.luminance[0].resize(count);
    view.a.resize(count);
    view.b.resize(count);
    for (size_t i = 0; i < count; i++, rgb += 3) {
        double r = rgb[0], g = rgb[1], b = rgb[2];
        // sRGB's primaries (IEC 61966-2-1), X and Z over those of its white.
        double x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505;
        double y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        double z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089;
        view.luminance[0][i] = float(white * y);
        view.a[i] = float(500 * (compress(x) - compress(y)));
        view.b[i] = float(200 * (compress(y) - compress(z)));
    }
    for (size_t i = 1; i < levels; i++) {
        Plane rows = blur_axis(view.luminance[i - 1], width, height, 1L << (i - 1), true);
        view.luminance[i] = blur_axis(rows, width, height, 1L << (i - 1), false);
    }
    return view;
}

// --- the metric ---------------------------------------------------------------------------------

struct Setting {
    std::array<double, bands> frequency; // cycles per degree
    std::array<double, bands> unease;    // the eye's best sensitivity over the one there
    size_t adaptation;                   // the level that blurs about one degree
};

Setting make_setting(size_t width)
{
    const double pi = std::acos(-1.0), best_frequency = 3.248; // at 100 candela per square metre
    double degrees = 2 * std::tan(degrees_wide / 2 * pi / 180) * 180 / pi;
    double pixels_per_degree = double(width) / degrees;
    Setting setting{};
    for (size_t i = 0; i < bands; i++) {
        setting.frequency[i] = 0.5 * pixels_per_degree / double(1 << i);
        setting.unease[i] = contrast_sensitivity(best_frequency, white) /
                            contrast_sensitivity(setting.frequency[i], white);
    }
    while (setting.adaptation < levels - 1 && (1 << setting.adaptation) < pixels_per_degree)
        setting.adaptation++;
    return setting;
}

// The factor, 1 to 10, by which the surroundings raise the threshold.
double elevation(const View &a, const View &b, const Setting &setting, double adapted, size_t i)
{
    double sum = 0, weighted = 0;
    for (size_t k = 0; k < bands; k++) {
        double detail = std::max(std::abs(a.luminance[k][i] - a.luminance[k + 1][i]),
                                 std::abs(b.luminance[k][i] - b.luminance[k + 1][i]));
        double mean = std::max(std::abs(a.luminance[k + 2][i]), std::abs(b.luminance[k + 2][i]));
        double contrast = detail / std::max(mean, least_luminance);
        sum += contrast;
        weighted += contrast * setting.unease[k] *
                    masking(contrast * contrast_sensitivity(setting.frequency[k], adapted));
    }
    return sum > 0 ? std::clamp(weighted / sum, 1.0, 10.0) : 1;
}

bool is_seen(const View &a, const View &b, const Setting &setting, size_t i)
{
    double difference = std::abs(a.luminance[0][i] - b.luminance[0][i]);
    double hue_a = a.a[i] - b.a[i], hue_b = a.b[i] - b.b[i];
    if (difference == 0 && hue_a == 0 && hue_b == 0)
        return false;
    double adapted =
        std::max((a.luminance[setting.adaptation][i] + b.luminance[setting.adaptation][i]) / 2.0,
                 least_luminance);
    double raised = elevation(a, b, setting, adapted, i);
    if (difference > raised * threshold(adapted))
        return true;
    // Below 10 candela per square metre, colour vision fades.
    double colour = adapted < 10 ? 0.01 : 1;
    return (hue_a * hue_a + hue_b * hue_b) * colour > raised;
}

} // namespace

size_t count_seen(const float *a, const float *b, size_t width, size_t height)
{
    View view_a = make_view(a, width, height), view_b = make_view(b, width, height);
    Setting setting = make_setting(width);
    size_t seen = 0;
    for (size_t i = 0; i < width * height; i++)
        seen += is_seen(view_a, view_b, setting, i);
    return seen;
}
