#include "output/image/png.h"

#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <new>
#include <png.h>

#include "core/status.h"
#include "output/files/atomic_file.h"

namespace insitu::output {

namespace {

// libpng leaves a function on error by longjmp, which skips destructors. So everything that owns
// memory lives in the caller's frame, in one of the two structures below, and the functions that
// call libpng have only pointers and integers of their own. The callbacks that libpng calls, in
// turn, let no exception out.

struct Coder {
  png_structp png = nullptr;
  png_infop info = nullptr;
  char message[200] = "";
};

void on_error(png_structp png, png_const_charp message) {
  Coder* coder = static_cast<Coder*>(png_get_error_ptr(png));
  std::snprintf(coder->message, sizeof coder->message, "%s", message);
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

using Counted = core::CountedAllocator<std::uint8_t>;

struct Encoder : Coder {
  explicit Encoder(const Counted& counted) : bytes(counted) {}
  core::CountedVector<std::uint8_t> bytes;
  ~Encoder() { png_destroy_write_struct(&png, &info); }
};

void append_bytes(png_structp png, png_bytep data, std::size_t count) {
  bool fits = true;
  try {
    core::CountedVector<std::uint8_t>& bytes = static_cast<Encoder*>(png_get_io_ptr(png))->bytes;
    bytes.insert(bytes.end(), data, data + count);
  } catch (const std::bad_alloc&) {
    fits = false;
  } catch (const core::Error&) { // of counted memory
    fits = false;
  }
  if (!fits)
    png_error(png, "out of memory");
}

void no_flush(png_structp) {}

/// What libpng is told to write; text may be null.
struct Raster {
  int width, height, bit_depth, color_type;
  const std::uint8_t* bytes;
  std::size_t stride;
  png_textp text = nullptr;
  int text_count = 0;
};

/// False if libpng gave up; the reason is then in `encoder.message`.
bool encode_with_libpng(Encoder& encoder, const Raster& image) {
  encoder.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &encoder, on_error, on_warning);
  encoder.info = encoder.png == nullptr ? nullptr : png_create_info_struct(encoder.png);
  if (encoder.info == nullptr)
    return false;
  if (setjmp(png_jmpbuf(encoder.png)) != 0)
    return false;
  png_set_write_fn(encoder.png, &encoder, append_bytes, no_flush);
  png_set_IHDR(encoder.png, encoder.info, png_uint_32(image.width), png_uint_32(image.height),
               image.bit_depth, image.color_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (image.bit_depth == 8)
    png_set_sRGB(encoder.png, encoder.info, PNG_sRGB_INTENT_PERCEPTUAL);
  if (image.text_count > 0)
    png_set_text(encoder.png, encoder.info, image.text, image.text_count);
  // A frame is written while the solver waits: low effort, and the filters that suit smooth
  // shading.
  png_set_compression_level(encoder.png, 3);
  png_set_filter(encoder.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB | PNG_FILTER_UP);
  png_write_info(encoder.png, encoder.info);
  for (int y = 0; y < image.height; ++y)
    png_write_row(encoder.png, image.bytes + std::size_t(y) * image.stride);
  png_write_end(encoder.png, encoder.info);
  return true;
}

void encode_to_file(const std::string& path, const Raster& image, const Counted& counted) {
  Encoder encoder(counted);
  // As much as if nothing could be compressed: so that memory does not depend on what is seen.
  const auto rows = std::size_t(image.height);
  encoder.bytes.reserve(rows * image.stride + rows * image.stride / 1000 + 16 * rows + 1024);
  if (!encode_with_libpng(encoder, image))
    throw core::Error(INSITU_ERROR_FILE, "cannot write '" + path + "': libpng: " + encoder.message);
  AtomicFile file(path);
  file.write(encoder.bytes.data(), encoder.bytes.size());
  file.commit();
}

/// Throws unless `count` numbers make an image of that size and one of two numbers of channels.
void require_size(const std::string& path, int width, int height, int channels, int few, int many,
                  std::size_t count, const char* what) {
  const std::size_t expected = std::size_t(width) * std::size_t(height) * std::size_t(channels);
  if (width < 1 || height < 1 || (channels != few && channels != many) || count != expected) {
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      "image for '" + path + "': " + std::to_string(width) + " x " +
                          std::to_string(height) + " pixels of " + std::to_string(channels) +
                          " channels do not make " + std::to_string(count) + " " + what);
  }
}

struct Decoder : Coder {
  std::vector<std::uint8_t> file;
  std::size_t position = 0;
  ~Decoder() { png_destroy_read_struct(&png, &info, nullptr); }
};

void take_bytes(png_structp png, png_bytep data, std::size_t count) {
  Decoder* decoder = static_cast<Decoder*>(png_get_io_ptr(png));
  if (count > decoder->file.size() - decoder->position)
    png_error(png, "the file ends too early");
  std::memcpy(data, decoder->file.data() + decoder->position, count);
  decoder->position += count;
}

/// Reads the header and asks for 8-bit RGB or RGBA.
bool start_decoding(Decoder& decoder, PngImage& image) {
  decoder.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &decoder, on_error, on_warning);
  decoder.info = decoder.png == nullptr ? nullptr : png_create_info_struct(decoder.png);
  if (decoder.info == nullptr)
    return false;
  if (setjmp(png_jmpbuf(decoder.png)) != 0)
    return false;
  png_set_read_fn(decoder.png, &decoder, take_bytes);
  png_read_info(decoder.png, decoder.info);
  png_set_expand(decoder.png);
  png_set_scale_16(decoder.png);
  png_set_gray_to_rgb(decoder.png);
  png_set_interlace_handling(decoder.png);
  png_read_update_info(decoder.png, decoder.info);
  image.width = int(png_get_image_width(decoder.png, decoder.info));
  image.height = int(png_get_image_height(decoder.png, decoder.info));
  image.channels = int(png_get_channels(decoder.png, decoder.info));
  return true;
}

bool finish_decoding(Decoder& decoder, png_bytepp rows) {
  if (setjmp(png_jmpbuf(decoder.png)) != 0)
    return false;
  png_read_image(decoder.png, rows);
  png_read_end(decoder.png, nullptr);
  return true;
}

[[noreturn]] void throw_unreadable(const std::string& path, const std::string& reason) {
  throw core::Error(INSITU_ERROR_FILE, "cannot read '" + path + "' as PNG: " + reason);
}

} // namespace

void write_png(const std::string& path, const PngImage& image) {
  require_size(path, image.width, image.height, image.channels, 3, 4, image.pixels.size(), "bytes");
  encode_to_file(path,
                 {image.width, image.height, 8,
                  image.channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB,
                  image.pixels.data(), std::size_t(image.width) * std::size_t(image.channels)},
                 image.pixels.get_allocator());
}

void write_png(const std::string& path, const PngValues& image) {
  require_size(path, image.width, image.height, image.channels, 1, 3, image.values.size(),
               "values");
  const Counted counted(image.values.get_allocator());
  core::CountedVector<std::uint8_t> bytes(counted); // the more significant one first
  bytes.reserve(2 * image.values.size());
  for (const std::uint16_t value : image.values) {
    bytes.push_back(std::uint8_t(value >> 8));
    bytes.push_back(std::uint8_t(value));
  }
  std::vector<std::pair<std::string, std::string>> kept = image.text;
  std::vector<png_text> text;
  for (auto& [key, value] : kept) {
    png_text entry{};
    entry.compression = PNG_TEXT_COMPRESSION_NONE;
    entry.key = key.data();
    entry.text = value.data();
    entry.text_length = value.size();
    text.push_back(entry);
  }
  encode_to_file(path,
                 {image.width, image.height, 16,
                  image.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB, bytes.data(),
                  2 * std::size_t(image.width) * std::size_t(image.channels), text.data(),
                  int(text.size())},
                 counted);
}

void write_png(const std::string& path, const core::Image& image, bool keep_alpha) {
  write_png(path, to_srgb(image, keep_alpha));
}

PngImage read_png(const std::string& path) {
  Decoder decoder;
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in)
    throw core::Error(INSITU_ERROR_FILE, "cannot open '" + path + "'");
  const std::streamoff size = in.tellg();
  decoder.file.resize(size > 0 ? std::size_t(size) : 0);
  in.seekg(0);
  in.read(reinterpret_cast<char*>(decoder.file.data()), std::streamsize(decoder.file.size()));
  if (!in || size < 8 || png_sig_cmp(decoder.file.data(), 0, 8) != 0)
    throw_unreadable(path, "it does not begin as a PNG file");
  PngImage image;
  if (!start_decoding(decoder, image))
    throw_unreadable(path, decoder.message);
  const std::size_t stride = std::size_t(image.width) * std::size_t(image.channels);
  image.pixels.resize(stride * std::size_t(image.height));
  std::vector<png_bytep> rows(std::size_t(image.height));
  for (std::size_t y = 0; y < rows.size(); ++y)
    rows[y] = image.pixels.data() + y * stride;
  if (!finish_decoding(decoder, rows.data()))
    throw_unreadable(path, decoder.message);
  return image;
}

} // namespace insitu::output
