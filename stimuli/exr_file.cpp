// The one file that knows OpenEXR.
#include "stimuli/exr_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/files.h"

namespace equilux {
namespace {

constexpr int kMaxSide = 16384;

std::vector<const char*> channel_names(int channels) {
  return channels == 1 ? std::vector<const char*>{"Y"} : std::vector<const char*>{"R", "G", "B"};
}

Imf::FrameBuffer make_frame_buffer(HdrImage& image, const Imath::V2i& origin) {
  Imf::FrameBuffer buffer;
  const std::size_t pixel_bytes = sizeof(float) * static_cast<std::size_t>(image.channels);
  const std::size_t row_bytes = pixel_bytes * static_cast<std::size_t>(image.width);
  std::size_t channel = 0;
  for (const char* name : channel_names(image.channels)) {
    auto* base = reinterpret_cast<char*>(image.values.data() + channel++);
    base -= static_cast<std::ptrdiff_t>(pixel_bytes) * origin.x +
            static_cast<std::ptrdiff_t>(row_bytes) * origin.y;
    buffer.insert(name, Imf::Slice(Imf::FLOAT, base, pixel_bytes, row_bytes));
  }
  return buffer;
}

HdrImage make_image(const Imf::Header& header, const std::string& source) {
  const Imath::Box2i& window = header.dataWindow();
  const auto width = std::int64_t{window.max.x} - window.min.x + 1,
             height = std::int64_t{window.max.y} - window.min.y + 1;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    throw InputError(source, "dataWindow", fmt::format("1 to {} pixels a side", kMaxSide),
                     fmt::format("{} x {}", width, height));
  }
  const bool has_luminance = header.channels().findChannel("Y") != nullptr;
  const int channels = has_luminance ? 1 : 3;
  for (const char* name : channel_names(channels)) {
    if (!header.channels().findChannel(name)) throw InputError(source, "channels", "R, G, B, or Y", "others");
  }
  return HdrImage(static_cast<int>(width), static_cast<int>(height), channels);
}

void check_finite(const HdrImage& image, const std::string& source) {
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    if (std::isfinite(image.values[i])) continue;
    const std::size_t pixel = i / static_cast<std::size_t>(image.channels);
    const auto width = static_cast<std::size_t>(image.width);
    throw InputError(source, fmt::format("pixel ({}, {})", pixel % width, pixel / width), "finite values",
                     fmt::format("{}", image.values[i]));
  }
}

ExrFile read_exr(const std::filesystem::path& path) {
  Imf::InputFile input(path.c_str(), 0);
  const Imf::Header& header = input.header();
  ExrFile file{make_image(header, path.string()), {}};
  input.setFrameBuffer(make_frame_buffer(file.image, header.dataWindow().min));
  input.readPixels(header.dataWindow().min.y, header.dataWindow().max.y);
  for (auto attribute = header.begin(); attribute != header.end(); ++attribute) {
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute.attribute())) {
      file.metadata[attribute.name()] = text->value();
    }
  }
  check_finite(file.image, path.string());
  return file;
}

// A file in memory: OpenEXR's own file streams lose the errors of the last bytes, which are written in a
// destructor.
class MemoryStream : public Imf::OStream {
 public:
  MemoryStream() : Imf::OStream("memory") {}
  void write(const char bytes[], int count) override {
    bytes_.resize(std::max(bytes_.size(), place_ + static_cast<std::size_t>(count)));
    std::copy_n(bytes, count, bytes_.begin() + static_cast<std::ptrdiff_t>(place_));
    place_ += static_cast<std::size_t>(count);
  }
  std::uint64_t tellp() override { return place_; }
  void seekp(std::uint64_t place) override { place_ = place; }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  std::size_t place_ = 0;
};

std::string encode_exr(HdrImage image, const ExrMetadata& metadata) {
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const char* name : channel_names(image.channels))
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  for (const auto& [name, value] : metadata) header.insert(name, Imf::StringAttribute(value));
  MemoryStream stream;
  {
    Imf::OutputFile output(stream, header, 0);
    output.setFrameBuffer(make_frame_buffer(image, {0, 0}));
    output.writePixels(image.height);
  }
  return stream.take();
}

}  // namespace

ExrFile load_exr(const std::filesystem::path& path) {
  if (!is_file(path)) throw InputError(path.string(), "", "an EXR file", "no such file");
  try {  // the boundary to a library that throws its own
    return read_exr(path);
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    throw InputError(path.string(), "", "a whole EXR file", error.what());
  }
}

void save_exr(const HdrImage& image, const ExrMetadata& metadata, const std::filesystem::path& path) {
  for (float value : image.values) EQ_CHECK(std::isfinite(value), path.string(), value);
  save_text(path, encode_exr(image, metadata));
}

}  // namespace equilux
