// raykit-image: pictures in every format of OpenImageIO, for the library, which does not link it (a
// process that does takes a quarter of a second to start).
//
//   raykit-image read             pictures to standard output, one for each request on standard
//                                 input; each a picture or a reason, after an rk_helper_answer
//   raykit-image write FILE       picture from standard input, in the format of FILE's ending
//   raykit-image --version        the version, that of the drivers
//
// Pictures in streams have the format of image_stream.h.
// Errors of `write`, and those that end `read`, are one line on standard error that begins with the
// file's name, and exit status 1.
#include "base/sanitized.h"
#include "io/helper_answer.h"
#include "io/image_helper/bmp.h"
#include "io/image_helper/dds.h"
#include "io/image_shape.h"
#include "io/image_stream.h"
#include "io/image_world.h"
#include "io/little_endian.h"

#include <OpenImageIO/color.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

namespace {

// Unlike a vector's, its values are not set to zero: the reader detects a small file that claims to
// be a huge picture before the memory is touched.
class Floats {
  public:
    explicit Floats(size_t wanted) : values(new float[wanted]), count(wanted)
    {
    }
    float *data() const
    {
        return values.get();
    }
    size_t size() const
    {
        return count;
    }
    float *begin() const
    {
        return values.get();
    }
    float *end() const
    {
        return values.get() + count;
    }

  private:
    std::unique_ptr<float[]> values;
    size_t count;
};

struct Picture {
    int width, height;
    Floats rgb; // linear, row by row from the top
};

const char *const no_memory = "no memory for its pixels: choose a smaller picture";

[[noreturn]] void fail(const std::string &path, const std::string &what)
{
    throw std::runtime_error(path + ": " + what);
}

// OpenImageIO reports a line per failure; the first is the cause of the others.
std::string first_line(const std::string &text)
{
    return text.substr(0, text.find('\n'));
}

std::string size_text(const Picture &picture)
{
    return std::to_string(picture.width) + " x " + std::to_string(picture.height);
}

// --- limits -------------------------------------------------------------------------------------

// Sanitizers reserve terabytes, and are several times slower.
#ifdef RK_SANITIZED
const bool sanitized = true;
#else
const bool sanitized = false;
#endif

char time_line[1400]; // written beforehand: a signal handler may make system calls only

void on_time(int)
{
    if (::write(STDERR_FILENO, time_line, std::strlen(time_line)) < 0)
        ::_exit(1);
    ::_exit(1);
}

void limit(int resource, uint64_t value)
{
    struct rlimit now;
    if (::getrlimit(resource, &now) != 0)
        return;
    now.rlim_cur = now.rlim_max == RLIM_INFINITY || value < now.rlim_max ? value : now.rlim_max;
    ::setrlimit(resource, &now);
}

uint64_t seconds_used()
{
    struct rusage usage;
    return ::getrusage(RUSAGE_SELF, &usage) == 0
               ? uint64_t(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) + 1
               : 0;
}

// Addresses that the libraries take, which grow with the machine's cores.
uint64_t addresses_used()
{
    unsigned long long pages = 0;
    std::FILE *file = std::fopen("/proc/self/statm", "r");
    if (file && std::fscanf(file, "%llu", &pages) != 1)
        pages = 0;
    if (file)
        std::fclose(file);
    return pages * uint64_t(::sysconf(_SC_PAGESIZE));
}

// A picture takes memory for its pixels, in the file's form, as floats and turned upright, and time
// for its bytes and pixels. One that takes more is damaged, or made to harm.
void limit_cost(const std::string &path, uint64_t most_pixels)
{
    struct stat status = {};
    ::stat(path.c_str(), &status);
    const uint64_t bytes = uint64_t(status.st_size), megabyte = 1 << 20;
    const uint64_t seconds = 20 + bytes / megabyte + most_pixels / (4 * megabyte);
    std::snprintf(time_line, sizeof time_line,
                  "%.900s: takes more than %llu s of processor time, which is too much for a "
                  "picture of %llu bytes: it is damaged: save or download it again\n",
                  path.c_str(), static_cast<unsigned long long>(seconds),
                  static_cast<unsigned long long>(bytes));
    std::signal(SIGXCPU, on_time);
    if (sanitized)
        return;
    static const uint64_t base = addresses_used() + 1024 * megabyte;
    limit(RLIMIT_AS, base + 64 * most_pixels + 128 * bytes);
    limit(RLIMIT_CPU, seconds_used() + seconds);
}

// --- reading ------------------------------------------------------------------------------------

void check_size(const std::string &path, const OIIO::ImageSpec &spec, size_t most_pixels)
{
    const int most = RK_IMAGE_STREAM_SIDE_MAX;
    if (spec.width < 1 || spec.height < 1 || spec.width > most || spec.height > most)
        fail(path, "claims " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                       " pixels: choose one with sides of 1 to " + std::to_string(most));
    if (size_t(spec.width) * size_t(spec.height) > most_pixels)
        fail(path, "has " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                       " pixels, more than the " + std::to_string(most_pixels) +
                       " allowed here: make it smaller");
    if (spec.deep || spec.depth > 1)
        fail(path, "is a deep or volume picture; flatten it, for instance by oiiotool --flatten");
}

// As the picture will be when it is upright.
void check_shape(const std::string &path, const OIIO::ImageSpec &spec, rk_image_shape shape)
{
    int orientation = spec.get_int_attribute("Orientation", 1);
    bool lies = orientation >= 5 && orientation <= 8;
    int width = lies ? spec.height : spec.width, height = lies ? spec.width : spec.height;
    const char *needed = rk_image_shape_fault(shape, size_t(width), size_t(height));
    if (needed)
        fail(path, "has " + std::to_string(width) + " x " + std::to_string(height) +
                       " pixels: " + needed);
}

// The first colour channel and the number of colour channels: 3 for RGB, or 1 for grey.
struct Channels {
    int first, count;
};

// "" if there is none.
std::string first_layer(const OIIO::ImageSpec &spec)
{
    for (const std::string &name : spec.channelnames) {
        const size_t end = name.size() > 2 ? name.size() - 2 : 0;
        const std::string layer = name.substr(0, end);
        if (end > 0 && name.compare(end, 2, ".R") == 0 && spec.channelindex(layer + ".G") >= 0 &&
            spec.channelindex(layer + ".B") >= 0)
            return layer;
    }
    return "";
}

Channels colour_channels(const std::string &path, const OIIO::ImageSpec &spec)
{
    if (spec.channelindex("RY") >= 0 || spec.channelindex("BY") >= 0)
        fail(path, "stores luminance and chroma, which cannot be read; save it as RGB");
    int red = spec.channelindex("R");
    if (red >= 0 && spec.channelindex("G") == red + 1 && spec.channelindex("B") == red + 2)
        return {red, 3};
    const std::string layer = red < 0 ? first_layer(spec) : "";
    if (!layer.empty())
        fail(path, "has its colours in layers (the first: " + layer +
                       "), and no R, G and B outside them; save one as a picture, for instance by "
                       "oiiotool --ch R=" +
                       layer + ".R,G=" + layer + ".G,B=" + layer + ".B");
    return {0, spec.nchannels >= 3 ? 3 : 1};
}

// -1 if there is none. Of a GIF, OpenImageIO 2.4 gives a number one too high.
int alpha_channel(const OIIO::ImageSpec &spec)
{
    return spec.alpha_channel < spec.nchannels ? spec.alpha_channel : spec.nchannels - 1;
}

Channels channels_of(const std::string &path, const OIIO::ImageSpec &spec,
                     rk_image_stream_part part)
{
    const int alpha = alpha_channel(spec);
    if (part != RK_IMAGE_STREAM_COLOUR && alpha >= 0)
        return {alpha, 1};
    if (part == RK_IMAGE_STREAM_ALPHA)
        fail(path, "has no alpha channel; save it with one");
    return colour_channels(path, spec);
}

float decode_srgb(double stored)
{
    return float(stored <= 0.04045 ? stored / 12.92 : std::pow((stored + 0.055) / 1.055, 2.4));
}

// The curve from stored to linear values; an empty function if they are linear already. Integers
// are sRGB-encoded and floats are linear, unless the file names a curve. The names of linear spaces
// begin with "lin": linear, lin_srgb, lin_rec709. OpenImageIO calls every PNM Rec709, also one of
// floats.
std::function<float(double)> curve_of(const OIIO::ImageSpec &spec)
{
    std::string space = spec.get_string_attribute("oiio:ColorSpace");
    std::transform(space.begin(), space.end(), space.begin(), ::tolower);
    float gamma = spec.get_float_attribute("oiio:Gamma");
    if (space.rfind("lin", 0) == 0 || space == "scene_linear" || gamma == 1)
        return {};
    if (gamma > 0 && std::abs(1 / gamma - 1 / 2.2) >= 0.001)
        return [gamma](double stored) { return float(std::pow(stored, double(gamma))); };
    if (spec.format.is_floating_point() && space.rfind("srgb", 0) != 0 && !(gamma > 0))
        return {};
    return decode_srgb;
}

// The curve, for integers as a table: there are fewer stored values than pixels.
class Linearizer {
  public:
    explicit Linearizer(const OIIO::ImageSpec &spec) : curve(curve_of(spec))
    {
        levels = spec.format == OIIO::TypeDesc::UINT8    ? 256
                 : spec.format == OIIO::TypeDesc::UINT16 ? 65536
                                                         : 0;
        for (int i = 0; curve && i < levels; i++)
            table.push_back(curve(double(i) / (levels - 1)));
        const float exposure = spec.get_float_attribute("hdr:exposure", 1);
        if (exposure > 0 && std::isfinite(exposure)) // Radiance multiplies by it and writes it down
            divisor = exposure;
    }

    void apply(const Floats &values) const
    {
        if (curve)
            for (float &value : values)
                value =
                    levels ? table[size_t(std::lrint(value * float(levels - 1)))] : curve(value);
        if (divisor != 1)
            for (float &value : values)
                value /= divisor;
    }

  private:
    std::function<float(double)> curve;
    int levels;
    std::vector<float> table;
    float divisor = 1;
};

void check_finite(const std::string &path, const Picture &picture)
{
    auto bad = std::find_if(picture.rgb.begin(), picture.rgb.end(),
                            [](float value) { return !std::isfinite(value); });
    if (bad == picture.rgb.end())
        return;
    auto pixel = (bad - picture.rgb.begin()) / 3;
    fail(path, "the pixel at x " + std::to_string(pixel % picture.width) + ", y " +
                   std::to_string(pixel / picture.width) +
                   " is not a finite number; repair it, for instance by oiiotool --fixnan box3");
}

// Of the picture as it is stored, the pixel of number x + width * y that is upright at (x, y).
size_t stored_pixel(int orientation, int width, int height, int x, int y)
{
    const bool lies = orientation >= 5;
    int across = lies ? y : x, down = lies ? x : y;
    if (orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8)
        across = width - 1 - across;
    if (orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7)
        down = height - 1 - down;
    return size_t(down) * size_t(width) + size_t(across);
}

// Cameras store the sensor's picture and a note on the camera's orientation. OpenImageIO 2.4 turns
// two of the eight upside down.
void turn_upright(Picture &picture, int orientation)
{
    if (orientation <= 1 || orientation > 8)
        return;
    const bool lies = orientation >= 5;
    const int width = lies ? picture.height : picture.width;
    const int height = lies ? picture.width : picture.height;
    Floats rgb(picture.rgb.size());
    float *to = rgb.data();
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++, to += 3)
            std::copy_n(picture.rgb.data() +
                            3 * stored_pixel(orientation, picture.width, picture.height, x, y),
                        3, to);
    picture = Picture{width, height, std::move(rgb)};
}

bool is_openexr_cube(const OIIO::ImageSpec &spec)
{
    return spec.get_string_attribute("textureformat") == "CubeFace Environment" &&
           spec.height == 6 * spec.width;
}

// OpenEXR's cube is right-handed and looks along its +z, so +x is on the left, and the faces above
// and below are turned by 180 degrees (ImfEnvmap.h). This makes the strip of other programs, as
// io/environment_file.h describes it.
void order_openexr_cube(Picture &strip)
{
    static const int from[6] = {1, 0, 2, 3, 4, 5};
    const size_t side = size_t(strip.width), face = 3 * side * side;
    Floats rgb(strip.rgb.size());
    for (size_t i = 0; i < 6; i++) {
        const float *stored = strip.rgb.data() + size_t(from[i]) * face;
        for (size_t k = 0; k < side * side; k++)
            std::copy_n(stored + 3 * (i == 2 || i == 3 ? side * side - 1 - k : k), 3,
                        rgb.data() + i * face + 3 * k);
    }
    strip.rgb = std::move(rgb);
}

// An EXR file may store a part of its picture, which is what the display window shows, or more than
// it. An environment has no part that may be missing.
void check_window(const std::string &path, const OIIO::ImageSpec &spec, rk_image_shape shape)
{
    if (shape != RK_IMAGE_ENVIRONMENT || is_openexr_cube(spec) ||
        (spec.full_width == spec.width && spec.full_height == spec.height) ||
        std::min(spec.full_width, spec.full_height) < 1 ||
        !spec.get_string_attribute("textureformat").empty())
        return;
    fail(path, "stores " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                   " pixels of a picture of " + std::to_string(spec.full_width) + " x " +
                   std::to_string(spec.full_height) +
                   ": save it whole, for instance by oiiotool --croptofull");
}

Floats make_values(const OIIO::ImageSpec &spec, int channels)
{
    return Floats(size_t(spec.width) * size_t(spec.height) * size_t(channels));
}

// The display window, if it is another than that of the data. Other formats have places on a page.
OIIO::ImageSpec shown_of(const OIIO::ImageSpec &spec)
{
    OIIO::ImageSpec shown = spec;
    const bool is_environment =
        spec.get_string_attribute("textureformat").find("Environment") != std::string::npos;
    if (!spec.get_int_attribute("raykit:exr") || is_environment)
        return shown;
    shown.x = spec.full_x, shown.y = spec.full_y;
    shown.width = spec.full_width, shown.height = spec.full_height;
    return shown;
}

bool is_shown_whole(const OIIO::ImageSpec &spec)
{
    const OIIO::ImageSpec shown = shown_of(spec);
    return shown.x == spec.x && shown.y == spec.y && shown.width == spec.width &&
           shown.height == spec.height;
}

// Black and transparent where nothing is stored.
Floats show(const Floats &stored, const OIIO::ImageSpec &spec, const OIIO::ImageSpec &shown,
            int channels)
{
    Floats values = make_values(shown, channels);
    std::fill(values.begin(), values.end(), 0.0f);
    const int64_t left = std::max(spec.x, shown.x), top = std::max(spec.y, shown.y);
    const int64_t right = std::min(int64_t(spec.x) + spec.width, int64_t(shown.x) + shown.width);
    const int64_t bottom = std::min(int64_t(spec.y) + spec.height, int64_t(shown.y) + shown.height);
    for (int64_t y = top; y < bottom && left < right; y++)
        std::copy_n(stored.data() + ((y - spec.y) * spec.width + left - spec.x) * channels,
                    (right - left) * channels,
                    values.data() + ((y - shown.y) * shown.width + left - shown.x) * channels);
    return values;
}

Floats replicate(const Floats &grey)
{
    Floats rgb(grey.size() * 3);
    for (size_t i = 0; i < rgb.size(); i++)
        rgb.data()[i] = grey.data()[i / 3];
    return rgb;
}

Floats mean(const Floats &rgb)
{
    Floats grey(rgb.size() / 3);
    for (size_t i = 0; i < grey.size(); i++)
        grey.data()[i] = (rgb.data()[3 * i] + rgb.data()[3 * i + 1] + rgb.data()[3 * i + 2]) / 3;
    return grey;
}

// The system's reason says more than OpenImageIO's.
void check_readable(const std::string &path)
{
    std::FILE *file = std::fopen(path.c_str(), "rb");
    bool readable = file && (std::fgetc(file) != EOF || !std::ferror(file));
    std::string reason = std::strerror(errno);
    if (file)
        std::fclose(file);
    if (!readable)
        fail(path, "cannot be read: " + reason + "; check its name and permissions");
}

// Some readers fail without a reason.
[[noreturn]] void fail_damaged(const std::string &path, const std::string &reason)
{
    fail(path,
         "is damaged" + (reason.empty() ? reason : ": " + reason) + "; save or download it again");
}

// 1 for pictures that must be read as a whole: those in tiles, those to be turned, and parts.
int world_factor(const OIIO::ImageSpec &spec, rk_image_shape shape, rk_image_stream_part part,
                 size_t least_width)
{
    if (shape != RK_IMAGE_ENVIRONMENT || part != RK_IMAGE_STREAM_COLOUR || spec.tile_width > 0 ||
        spec.get_int_attribute("Orientation", 1) > 1 || !is_shown_whole(spec) ||
        !rk_image_shape_has_world(size_t(spec.width), size_t(spec.height)))
        return 1;
    return int(rk_image_world_factor(size_t(spec.width), size_t(spec.height), least_width));
}

// Reads as many rows at a time as become one.
Picture read_means(const std::string &path, OIIO::ImageInput &input, const OIIO::ImageSpec &spec,
                   Channels channels, int factor)
{
    Picture picture{spec.width / factor, spec.height / factor,
                    Floats(size_t(spec.width / factor) * size_t(spec.height / factor) * 3)};
    Floats rows(size_t(spec.width) * size_t(factor) * size_t(channels.count));
    std::vector<double> shares(static_cast<size_t>(factor));
    const Linearizer linearizer(spec);
    for (int y = 0; y < picture.height; y++) {
        const int first = y * factor;
        if (!input.read_scanlines(0, 0, spec.y + first, spec.y + first + factor, 0, channels.first,
                                  channels.first + channels.count, OIIO::TypeDesc::FLOAT,
                                  rows.data()) ||
            input.has_error())
            fail_damaged(path, first_line(input.geterror()));
        linearizer.apply(rows);
        rk_image_world_shares(shares.data(), size_t(factor), size_t(first), size_t(spec.height));
        const Floats grey = channels.count == 3 ? Floats(0) : replicate(rows);
        rk_image_world_average(picture.rgb.data() + 3 * size_t(y) * size_t(picture.width),
                               channels.count == 3 ? rows.data() : grey.data(), size_t(spec.width),
                               size_t(factor), shares.data());
    }
    return picture;
}

// Leaves the file after the empty line that ends Radiance's header. The last FORMAT, or "".
std::string radiance_format(std::istream &file)
{
    std::string line, format;
    while (std::getline(file, line) && !line.empty())
        if (line.rfind("FORMAT=", 0) == 0)
            format = line.substr(7);
    return format;
}

// In a picture that begins without the mark of the newer encoding: is a pixel a run of the one
// before it, as no flat picture has? Its mantissas would have to be 128 or more.
bool has_old_runs(std::istream &file)
{
    unsigned char pixel[4];
    bool is_first = true;
    while (file.read(reinterpret_cast<char *>(pixel), sizeof pixel)) {
        if (is_first && pixel[0] == 2 && pixel[1] == 2 && pixel[2] < 128)
            return false;
        if (!is_first && pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1)
            return true;
        is_first = false;
    }
    return false;
}

// OpenImageIO calls what it does not know of Radiance's format damaged, or reads runs as pixels.
// Source: Radiance, ray/src/common/color.c.
void check_radiance(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    std::string line;
    if (!std::getline(file, line) || line.rfind("#?", 0) != 0)
        return;
    if (radiance_format(file).find("xyze") != std::string::npos)
        fail(path, "has colours in XYZ, which are not read: convert it to RGB, for instance by "
                   "Radiance's ra_xyze -r");
    if (std::getline(file, line) && has_old_runs(file))
        fail(path, "has Radiance's old run-length encoding, which is not read: save it again, "
                   "for instance by Radiance's ra_xyze -r");
}

// Each program that scales the values adds a line; OpenImageIO knows the last one only.
void multiply_exposures(const std::string &path, OIIO::ImageSpec &spec)
{
    std::ifstream file(path, std::ios::binary);
    std::string line;
    float product = 1;
    if (spec.find_attribute("hdr:exposure") == nullptr)
        return;
    while (std::getline(file, line) && !line.empty())
        if (line.rfind("EXPOSURE=", 0) == 0)
            product *= std::strtof(line.c_str() + std::strlen("EXPOSURE="), nullptr);
    spec.attribute("hdr:exposure", product);
}

// The format that the first bytes name, or NULL. A name may lie, or have no ending, as those of
// pictures within mesh files; OpenImageIO would then ask one reader after another.
const char *format_of(const std::string &path)
{
    char first[4] = {};
    std::ifstream(path, std::ios::binary).read(first, sizeof first);
    const std::string begin(first, sizeof first);
    if (first[0] == 'P' && std::strchr("123456fF", first[1]) &&
        std::isspace(static_cast<unsigned char>(first[2])))
        return "pnm";
    static const struct {
        const char *begin, *format;
    } formats[] = {
        {"\xff\xd8\xff", "jpeg"}, {"\x89PNG", "png"}, {"GIF8", "gif"},       {"BM", "bmp"},
        {"8BPS", "psd"},          {"#?", "hdr"},      {"v/1\x01", "openexr"}};
    for (const auto &each : formats)
        if (begin.compare(0, std::strlen(each.begin), each.begin) == 0)
            return each.format;
    return nullptr;
}

std::unique_ptr<OIIO::ImageInput> open_picture(const std::string &path,
                                               const OIIO::ImageSpec &wishes)
{
    const char *format = format_of(path);
    auto input = format ? OIIO::ImageInput::create(format) : nullptr;
    OIIO::ImageSpec spec;
    if (input && input->open(path, spec, wishes))
        return input;
    return OIIO::ImageInput::open(path, &wishes);
}

// OpenImageIO's reasons tell of itself, not of the file.
[[noreturn]] void fail_unknown(const std::string &path, const std::string &reason)
{
    if (reason.find("could not find a format reader") != std::string::npos)
        fail(path, "has a format that OpenImageIO does not read; convert it to PNG, HDR or EXR");
    if (reason.find("Unsupported compression type") != std::string::npos)
        fail(path, "is a DDS picture of a kind that is not read; convert it to PNG, HDR or EXR");
    fail(path, "cannot be read: " + reason + "; save it again, or as PNG, HDR or EXR");
}

struct Wish {
    size_t most_pixels = SIZE_MAX;
    rk_image_shape shape = RK_IMAGE_ANY;
    rk_image_stream_part part = RK_IMAGE_STREAM_COLOUR;
    size_t least_width = 0;
};

Channels check(const std::string &path, const OIIO::ImageSpec &spec, const Wish &wish)
{
    const OIIO::ImageSpec shown = shown_of(spec);
    check_size(path, spec, wish.most_pixels);
    check_window(path, spec, wish.shape);
    check_size(path, shown, wish.most_pixels);
    check_shape(path, shown, wish.shape);
    return channels_of(path, spec, wish.part);
}

// Of the values as they are stored.
Picture finish(const OIIO::ImageSpec &spec, Channels channels, Floats values, const Wish &wish)
{
    if (wish.part == RK_IMAGE_STREAM_COLOUR) {
        Linearizer(spec).apply(values);
    } else if (channels.count == 3) {
        values = mean(values), channels.count = 1;
    }
    Picture picture{spec.width, spec.height,
                    channels.count == 3 ? std::move(values) : replicate(values)};
    turn_upright(picture, spec.get_int_attribute("Orientation", 1));
    if (wish.shape == RK_IMAGE_ENVIRONMENT && is_openexr_cube(spec))
        order_openexr_cube(picture);
    return picture;
}

// Reads the values of some channels.
using Reader = std::function<void(Channels, float *)>;

// `may_be_padding`: an alpha that is 0 everywhere is none.
Picture read_whole(const std::string &path, OIIO::ImageSpec spec, const Wish &wish,
                   bool may_be_padding, const Reader &read)
{
    const Channels channels = check(path, spec, wish);
    Floats values = make_values(spec, channels.count);
    read(channels, values.data());
    if (may_be_padding && wish.part != RK_IMAGE_STREAM_COLOUR &&
        channels.first == alpha_channel(spec) &&
        std::all_of(values.begin(), values.end(), [](float value) { return value == 0; })) {
        spec.alpha_channel = -1;
        return read_whole(path, spec, wish, false, read);
    }
    const OIIO::ImageSpec shown = shown_of(spec);
    if (!is_shown_whole(spec))
        values = show(values, spec, shown, channels.count);
    return finish(shown, channels, std::move(values), wish);
}

using TargaHead = std::array<unsigned char, 18>;

TargaHead targa_head(const std::string &path)
{
    TargaHead head = {};
    std::ifstream(path, std::ios::binary).read(reinterpret_cast<char *>(head.data()), head.size());
    return head;
}

// The number of alpha bits is in the lowest four of this byte (Truevision, "TGA File Format
// Specification", field 5.6).
bool has_alpha_bits(const TargaHead &head)
{
    return (head[17] & 15) != 0;
}

// The number of the map's first colour (field 4.1), from which OpenImageIO 2.4 does not count.
void check_colour_map(const std::string &path, const TargaHead &head)
{
    const bool has_map = head[2] == 1 || head[2] == 9;
    const uint16_t first = rk_little_endian_16(&head[3]);
    if (has_map && first > 0)
        fail(path, "has a colour map that begins with number " + std::to_string(first) +
                       ", and only those from 0 on are read: save it without a colour map, or as "
                       "PNG");
}

Picture read_picture(const std::string &path, const Wish &wish = {})
{
    Bmp bmp;
    Dds dds;
    check_readable(path);
    check_radiance(path);
    if (bmp_open(path, &bmp))
        return read_whole(path, bmp.spec, wish, true, [&](Channels channels, float *to) {
            if (!bmp_read(path, bmp, channels.first, channels.count, to))
                fail_damaged(path, "it ends too early");
        });
    if (dds_open(path, &dds))
        return read_whole(path, dds.spec, wish, false, [&](Channels channels, float *to) {
            if (!dds_read(path, dds, channels.first, channels.count, to))
                fail_damaged(path, "it ends too early");
        });
    // Alpha is dropped, so colours must not be multiplied by it.
    OIIO::ImageSpec wishes;
    wishes["oiio:UnassociatedAlpha"] = 1;
    auto input = open_picture(path, wishes);
    if (!input)
        fail_unknown(path, first_line(OIIO::geterror()));
    OIIO::ImageSpec spec = input->spec();
    const bool is_targa = std::strcmp(input->format_name(), "targa") == 0;
    if (is_targa) {
        const TargaHead head = targa_head(path);
        check_colour_map(path, head);
        if (!has_alpha_bits(head))
            spec.alpha_channel = -1;
    }
    spec.attribute("raykit:exr", std::strcmp(input->format_name(), "openexr") == 0);
    multiply_exposures(path, spec);
    const Channels channels = check(path, spec, wish);
    const int factor = world_factor(spec, wish.shape, wish.part, wish.least_width);
    if (factor > 1)
        return read_means(path, *input, spec, channels, factor);
    return read_whole(path, spec, wish, is_targa, [&](Channels some, float *to) {
        // Some readers fill missing parts with grey and report success, but leave an error message.
        if (!input->read_image(0, 0, some.first, some.first + some.count, OIIO::TypeDesc::FLOAT,
                               to) ||
            input->has_error())
            fail_damaged(path, first_line(input->geterror()));
    });
}

Picture load(const std::string &path, const Wish &wish)
{
    Picture picture = read_picture(path, wish);
    check_finite(path, picture);
    return picture;
}

// --- streams ------------------------------------------------------------------------------------

void send(const Picture &picture)
{
    rk_image_stream_head head = {RK_IMAGE_STREAM_MAGIC, RK_IMAGE_STREAM_VERSION,
                                 uint32_t(picture.width), uint32_t(picture.height)};
    if (std::fwrite(&head, sizeof head, 1, stdout) != 1 ||
        std::fwrite(picture.rgb.data(), sizeof(float), picture.rgb.size(), stdout) !=
            picture.rgb.size() ||
        std::fflush(stdout) != 0)
        fail("standard output", std::strerror(errno));
}

Picture receive()
{
    const char *source = "standard input";
    rk_image_stream_head head;
    if (std::fread(&head, sizeof head, 1, stdin) != 1 || head.magic != RK_IMAGE_STREAM_MAGIC ||
        head.version != RK_IMAGE_STREAM_VERSION)
        fail(source, "is not a picture from this version of raykit");
    const uint32_t most = RK_IMAGE_STREAM_SIDE_MAX;
    if (head.width < 1 || head.height < 1 || head.width > most || head.height > most)
        fail(source, "each side of a picture must be 1 to " + std::to_string(most) + " pixels");
    Picture picture{int(head.width), int(head.height),
                    Floats(size_t(head.width) * head.height * 3)};
    if (std::fread(picture.rgb.data(), sizeof(float), picture.rgb.size(), stdin) !=
            picture.rgb.size() ||
        std::fgetc(stdin) != EOF)
        fail(source, "is shorter or longer than a picture of " + size_text(picture) + " pixels");
    return picture;
}

// --- writing ------------------------------------------------------------------------------------

// Beside the destination, with its ending, by which OpenImageIO chooses the format.
std::string temporary_name(const std::string &path)
{
    size_t slash = path.rfind('/'), dot = path.rfind('.');
    if (dot == std::string::npos || (slash != std::string::npos && dot < slash))
        fail(path, "has no ending that names a format; use one such as .exr");
    return path.substr(0, dot) + ".part-" + std::to_string(::getpid()) + path.substr(dot);
}

// The file being written, and its temporary name; both empty when nothing is written.
struct Unfinished {
    std::string path, temporary;
} unfinished;

// The temporary name for a signal handler, which may make system calls only.
const char *volatile unfinished_name;

void remove_unfinished()
{
    if (!unfinished.temporary.empty())
        ::unlink(unfinished.temporary.c_str());
    unfinished_name = nullptr;
    unfinished = {};
}

void on_interrupt(int signal)
{
    if (unfinished_name)
        ::unlink(unfinished_name);
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

// Ctrl-C reaches this process as well as its caller. Signals that the caller ignores stay ignored.
void remove_unfinished_when_interrupted()
{
    unfinished_name = unfinished.temporary.c_str();
    for (int signal : {SIGHUP, SIGINT, SIGTERM})
        if (std::signal(signal, on_interrupt) == SIG_IGN)
            std::signal(signal, SIG_IGN);
}

// libjpeg ends the whole process when the disk is full.
void on_exit_by_library()
{
    if (!unfinished.path.empty())
        std::fprintf(stderr, "%s: could not be written whole; free some space\n",
                     unfinished.path.c_str());
    remove_unfinished();
}

// Not every writer notices a full disk, so the file is read again.
void check_written(const Picture &picture)
{
    Picture back = read_picture(unfinished.temporary);
    if (back.width != picture.width || back.height != picture.height)
        fail(unfinished.temporary, "has changed its size");
}

[[noreturn]] void fail_to_write(const std::string &path, const std::string &reason)
{
    fail(path,
         "could not be written whole: " + reason + "; free some space, or choose another place");
}

void store(const std::string &path, Picture picture)
{
    auto output = OIIO::ImageOutput::create(path);
    if (!output)
        fail(path, "no such format: " + first_line(OIIO::geterror()) + "; use .exr or .png");
    OIIO::ImageSpec spec(picture.width, picture.height, 3, OIIO::TypeDesc::FLOAT);
    // Otherwise OpenImageIO stores the current time, and equal pictures would give different files.
    spec["DateTime"] = "1970:01:01 00:00:00";
    unfinished = {path, temporary_name(path)};
    std::atexit(on_exit_by_library);
    remove_unfinished_when_interrupted();
    if (!output->open(unfinished.temporary, spec))
        fail(path,
             "cannot be written: " + first_line(output->geterror()) + "; choose another place");
    if (!output->spec().format.is_floating_point()) // the format has no floats
        for (float &value : picture.rgb)
            value = OIIO::linear_to_sRGB(value > 0 ? std::min(value, 1.0f) : 0);
    if (!output->write_image(OIIO::TypeDesc::FLOAT, picture.rgb.data()) || !output->close())
        fail_to_write(path, first_line(output->geterror()));
    try {
        check_written(picture);
    } catch (const std::exception &error) {
        fail_to_write(path, error.what());
    }
    if (std::rename(unfinished.temporary.c_str(), path.c_str()) != 0)
        fail_to_write(path, std::strerror(errno));
    unfinished_name = nullptr;
    unfinished = {};
}

std::string one_line(std::string text)
{
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

// --- requests -----------------------------------------------------------------------------------

// False at the end of the input.
bool receive_request(rk_image_stream_request *request, std::string *path)
{
    if (std::fread(request, sizeof *request, 1, stdin) != 1)
        return false;
    if (request->magic != RK_IMAGE_STREAM_MAGIC || request->version != RK_IMAGE_STREAM_VERSION ||
        request->name_size > 1 << 16)
        fail("standard input", "is not a request from this version of raykit");
    path->resize(request->name_size);
    return std::fread(&(*path)[0], 1, path->size(), stdin) == path->size();
}

void send_answer(bool failed, size_t size)
{
    rk_helper_answer answer = {size, failed};
    std::fwrite(&answer, sizeof answer, 1, stdout);
}

void send_reason(const std::string &reason)
{
    const std::string line = one_line(reason).substr(0, 4000);
    send_answer(true, line.size());
    std::fwrite(line.data(), 1, line.size(), stdout);
    std::fflush(stdout);
}

// What was wrong with this picture is not wrong with the next.
void answer(const rk_image_stream_request &request, const std::string &path)
{
    try {
        limit_cost(path, request.most_pixels);
        const Picture picture =
            load(path, {request.most_pixels, rk_image_shape(request.shape),
                        rk_image_stream_part(request.part), request.least_width});
        send_answer(false, sizeof(rk_image_stream_head) + picture.rgb.size() * sizeof(float));
        send(picture);
    } catch (const std::bad_alloc &) {
        send_reason(path + ": " + no_memory);
    } catch (const std::exception &error) {
        send_reason(error.what());
    }
}

void serve()
{
    OIIO::attribute("threads", 4); // each reserves addresses
    rk_image_stream_request request;
    std::string path;
    while (receive_request(&request, &path))
        answer(request, path);
}

void run(const std::vector<std::string> &words)
{
    if (words.size() == 1 && words[0] == "read")
        serve();
    else if (words.size() == 2 && words[0] == "write")
        store(words[1], receive());
    else if (words.size() == 1 && words[0] == "--version")
        std::printf("raykit-image %s\n", PACKAGE_VERSION);
    else
        fail("raykit-image", "usage: raykit-image read | write FILE | --version");
}

} // namespace

int main(int argc, char **argv)
{
    std::vector<std::string> words(argv + 1, argv + argc);
    try {
        run(words);
        return 0;
    } catch (const std::bad_alloc &) {
        std::fprintf(stderr, "%s: %s\n", words.size() > 1 ? words[1].c_str() : "raykit-image",
                     no_memory);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "%s\n", one_line(error.what()).c_str());
    }
    remove_unfinished();
    return 1;
}
