// raykit-image: pictures in every format of OpenImageIO, for the library, which does not link it (a
// process that does takes a quarter of a second to start).
//
//   raykit-image read FILE MOST SHAPE   picture of up to MOST pixels, and of this shape (its number
//                                 in image_shape.h), to standard output
//   raykit-image alpha FILE MOST SHAPE  its alpha channel, as a grey picture of the stored values
//   raykit-image opacity FILE MOST SHAPE  the same, or its grey values if it has no alpha
//   raykit-image write FILE       picture from standard input, in the format of FILE's ending
//   raykit-image --version        the version, that of the drivers
//
// Pictures in streams have the format of image_stream.h.
// Errors are one line on standard error that begins with the file's name, and exit status 1.
#include "io/image_shape.h"
#include "io/image_stream.h"

#include <OpenImageIO/color.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
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

// --- reading ------------------------------------------------------------------------------------

void check_size(const std::string &path, const OIIO::ImageSpec &spec, size_t most_pixels)
{
    const int most = RK_IMAGE_STREAM_SIDE_MAX;
    if (spec.width < 1 || spec.height < 1 || spec.width > most || spec.height > most)
        fail(path, "claims " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                       " pixels: each side must be 1 to " + std::to_string(most));
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

Channels colour_channels(const std::string &path, const OIIO::ImageSpec &spec)
{
    if (spec.channelindex("RY") >= 0 || spec.channelindex("BY") >= 0)
        fail(path, "stores luminance and chroma, which cannot be read; save it as RGB");
    int red = spec.channelindex("R");
    if (red >= 0 && spec.channelindex("G") == red + 1 && spec.channelindex("B") == red + 2)
        return {red, 3};
    return {0, spec.nchannels >= 3 ? 3 : 1};
}

// What to read: colours, the alpha channel, or an opacity: the alpha channel, or else the colours.
enum class Part { colour, alpha, opacity };

Channels channels_of(const std::string &path, const OIIO::ImageSpec &spec, Part part)
{
    if (part != Part::colour && spec.alpha_channel >= 0)
        return {spec.alpha_channel, 1};
    if (part == Part::alpha)
        fail(path, "has no alpha channel");
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

// Integers by a table: there are fewer stored values than pixels.
void make_linear(const Floats &values, const OIIO::ImageSpec &spec)
{
    auto curve = curve_of(spec);
    if (!curve)
        return;
    int levels = spec.format == OIIO::TypeDesc::UINT8    ? 256
                 : spec.format == OIIO::TypeDesc::UINT16 ? 65536
                                                         : 0;
    std::vector<float> table;
    for (int i = 0; i < levels; i++)
        table.push_back(curve(double(i) / (levels - 1)));
    for (float &value : values)
        value = levels ? table[size_t(std::lrint(value * float(levels - 1)))] : curve(value);
}

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

// Cameras store the sensor's picture and a note on the camera's orientation.
void turn_upright(Picture &picture, int orientation)
{
    if (orientation <= 1 || orientation > 8)
        return;
    OIIO::ImageSpec spec(picture.width, picture.height, 3, OIIO::TypeDesc::FLOAT);
    OIIO::ImageBuf lying(spec, picture.rgb.data());
    lying.set_orientation(orientation);
    OIIO::ImageBuf upright = OIIO::ImageBufAlgo::reorient(lying);
    Floats rgb(picture.rgb.size());
    upright.get_pixels(OIIO::ROI(), OIIO::TypeDesc::FLOAT, rgb.data());
    picture.width = upright.spec().width;
    picture.height = upright.spec().height;
    picture.rgb = std::move(rgb);
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
        grey.data()[i] =
            (rgb.data()[3 * i] + rgb.data()[3 * i + 1] + rgb.data()[3 * i + 2]) / 3;
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
        fail(path, "cannot be read: " + reason);
}

// Some readers fail without a reason.
[[noreturn]] void fail_damaged(const std::string &path, const std::string &reason)
{
    fail(path,
         "is damaged" + (reason.empty() ? reason : ": " + reason) + "; save or download it again");
}

Picture read_picture(const std::string &path, size_t most_pixels = SIZE_MAX,
                     rk_image_shape shape = RK_IMAGE_ANY, Part part = Part::colour)
{
    check_readable(path);
    // Alpha is dropped, so colours must not be multiplied by it.
    OIIO::ImageSpec wishes;
    wishes["oiio:UnassociatedAlpha"] = 1;
    auto input = OIIO::ImageInput::open(path, &wishes);
    if (!input)
        fail(path, "cannot be read: " + first_line(OIIO::geterror()));
    OIIO::ImageSpec spec = input->spec();
    check_size(path, spec, most_pixels);
    check_shape(path, spec, shape);
    Channels channels = channels_of(path, spec, part);
    size_t pixels = size_t(spec.width) * size_t(spec.height);
    Floats values(pixels * size_t(channels.count));
    // Some readers fill missing parts with grey and report success, but leave an error message.
    if (!input->read_image(0, 0, channels.first, channels.first + channels.count,
                           OIIO::TypeDesc::FLOAT, values.data()) ||
        input->has_error())
        fail_damaged(path, first_line(input->geterror()));
    if (part == Part::colour)
        make_linear(values, spec);
    else if (channels.count == 3)
        values = mean(values), channels.count = 1;
    Picture picture{spec.width, spec.height,
                    channels.count == 3 ? std::move(values) : replicate(values)};
    turn_upright(picture, spec.get_int_attribute("Orientation", 1));
    return picture;
}

Picture load(const std::string &path, size_t most_pixels, rk_image_shape shape, Part part)
{
    Picture picture = read_picture(path, most_pixels, shape, part);
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
        fail(path, "has no ending that names a format, such as .exr");
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
        fail(path, "no such format: " + first_line(OIIO::geterror()));
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

bool is_part(const std::string &word, Part *part)
{
    *part = word == "alpha" ? Part::alpha : word == "opacity" ? Part::opacity : Part::colour;
    return *part != Part::colour || word == "read";
}

void run(const std::vector<std::string> &words)
{
    Part part;
    if (words.size() == 4 && is_part(words[0], &part))
        send(load(words[1], std::stoull(words[2]), rk_image_shape(std::stoi(words[3])), part));
    else if (words.size() == 2 && words[0] == "write")
        store(words[1], receive());
    else if (words.size() == 1 && words[0] == "--version")
        std::printf("raykit-image %s\n", PACKAGE_VERSION);
    else
        fail("raykit-image", "usage: raykit-image read|alpha|opacity FILE MOST SHAPE | write FILE | --version");
}

std::string one_line(std::string text)
{
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

} // namespace

int main(int argc, char **argv)
{
    std::vector<std::string> words(argv + 1, argv + argc);
    try {
        run(words);
        return 0;
    } catch (const std::bad_alloc &) {
        std::fprintf(stderr, "%s: no memory for its pixels: choose a smaller picture\n",
                     words.size() > 1 ? words[1].c_str() : "raykit-image");
    } catch (const std::exception &error) {
        std::fprintf(stderr, "%s\n", one_line(error.what()).c_str());
    }
    remove_unfinished();
    return 1;
}
