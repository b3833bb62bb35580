#include "output/image/exr.h"

#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfIntAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <cstring>
#include <limits>

#include "core/status.h"
#include "output/files/atomic_file.h"

namespace insitu::output {

namespace {

/// The file's bytes in memory: OpenEXR goes back to fill in its table of offsets, which a file that
/// appears whole cannot.
class Bytes final : public Imf::OStream {
public:
  Bytes(const std::string& path, const core::CountedAllocator<char>& counted)
      : OStream(path.c_str()), bytes_(counted) {}

  void write(const char data[], int count) override {
    const std::size_t end = position_ + std::size_t(count);
    if (end > bytes_.size())
      bytes_.resize(end);
    std::memcpy(bytes_.data() + position_, data, std::size_t(count));
    position_ = end;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = std::size_t(position); }

  void reserve(std::size_t count) { bytes_.reserve(count); }
  const core::CountedVector<char>& bytes() const { return bytes_; }

private:
  core::CountedVector<char> bytes_;
  std::size_t position_ = 0;
};

void add(Imf::Header& header, const ExrAttribute& attribute) {
  const std::string& name = attribute.name;
  if (const auto* text = std::get_if<std::string>(&attribute.value)) {
    header.insert(name, Imf::StringAttribute(*text));
  } else if (const auto* number = std::get_if<double>(&attribute.value)) {
    header.insert(name, Imf::DoubleAttribute(*number));
  } else {
    const std::int64_t whole = std::get<std::int64_t>(attribute.value);
    if (whole >= std::numeric_limits<int>::min() && whole <= std::numeric_limits<int>::max())
      header.insert(name, Imf::IntAttribute(int(whole)));
    else
      header.insert(name, Imf::DoubleAttribute(double(whole)));
  }
}

} // namespace

void write_exr(const std::string& path, int width, int height, std::span<const ExrChannel> channels,
               std::span<const ExrAttribute> attributes,
               const core::CountedAllocator<char>& counted) {
  if (width < 1 || height < 1)
    throw core::Error(INSITU_ERROR_ARGUMENT, "image for '" + path + "': a size of " +
                                                 std::to_string(width) + " x " +
                                                 std::to_string(height) + " pixels");
  Bytes bytes(path, counted);
  bytes.reserve(4 * std::size_t(width) * std::size_t(height) * channels.size() +
                16 * std::size_t(height) + 4096); // as if nothing could be compressed
  try {
    Imf::Header header(width, height);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const ExrAttribute& attribute : attributes)
      add(header, attribute);
    Imf::FrameBuffer buffer;
    for (const ExrChannel& channel : channels) {
      const bool is_float = std::holds_alternative<const float*>(channel.values);
      const Imf::PixelType type = is_float ? Imf::FLOAT : Imf::UINT;
      // OpenEXR reads through this pointer only.
      char* data = is_float ? const_cast<char*>(reinterpret_cast<const char*>(
                                  std::get<const float*>(channel.values)))
                            : const_cast<char*>(reinterpret_cast<const char*>(
                                  std::get<const std::uint32_t*>(channel.values)));
      header.channels().insert(channel.name, Imf::Channel(type));
      buffer.insert(channel.name, Imf::Slice(type, data, 4 * channel.stride,
                                             4 * channel.stride * std::size_t(width)));
    }
    // No threads of OpenEXR's own: they would be the solver's cores.
    Imf::OutputFile file(bytes, header, 0);
    file.setFrameBuffer(buffer);
    file.writePixels(height);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const core::Error&) { // of counted memory
    throw;
  } catch (const std::exception& e) {
    throw core::Error(INSITU_ERROR_FILE, "cannot write '" + path + "': OpenEXR: " + e.what());
  }
  AtomicFile file(path);
  file.write(bytes.bytes().data(), bytes.bytes().size());
  file.commit();
}

void write_exr(const std::string& path, const core::Image& image, bool keep_alpha,
               std::span<const ExrAttribute> attributes) {
  core::CountedVector<float> scaled(image.rgba.get_allocator());
  const float* pixels = image.rgba.data();
  if (keep_alpha) {
    scaled.assign(image.rgba.begin(), image.rgba.end());
    for (std::size_t i = 0; i < scaled.size(); i += 4)
      for (std::size_t c = 0; c < 3; ++c)
        scaled[i + c] *= scaled[i + 3];
    pixels = scaled.data();
  }
  std::vector<ExrChannel> channels{{"R", pixels, 4}, {"G", pixels + 1, 4}, {"B", pixels + 2, 4}};
  if (keep_alpha)
    channels.push_back({"A", pixels + 3, 4});
  write_exr(path, image.width, image.height, channels, attributes, image.rgba.get_allocator());
}

} // namespace insitu::output
