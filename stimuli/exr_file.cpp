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
#include <cstring>
#include <fstream>

#include "base/error.h"
#include "base/files.h"

namespace equilux {
namespace {

constexpr int kMaxSide = 16384;
constexpr std::int64_t kMaxOrigin =
    1 << 24;  // either way: pointers to a pixel (0, 0) that is not there stay in range
constexpr std::size_t kMaxHeaderBytes = 1 << 16;
constexpr std::size_t kMaxChannelBytes = 1024;  // of the list of channels: fifty of them
constexpr std::uintmax_t kMostInflated = 1032;  // bytes that deflate can make of one; RLE and PIZ make fewer
constexpr std::uintmax_t kLeastPixelBytes = 2;  // one channel of half floats

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

void check_size(std::int64_t width, std::int64_t height, std::uintmax_t file_bytes,
                const std::string& source) {
  const std::string size = fmt::format("{} x {}", width, height);
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
    throw InputError(source, "dataWindow", fmt::format("1 to {} pixels a side", kMaxSide), size);
  const auto pixels = static_cast<std::uintmax_t>(width) * static_cast<std::uintmax_t>(height);
  if (pixels * kLeastPixelBytes > kMostInflated * file_bytes) {
    throw InputError(source, "dataWindow", fmt::format("no more pixels than {} bytes can hold", file_bytes),
                     size);
  }
}

// The attributes of a header, as far as they are in the file.
class HeaderBytes {
 public:
  explicit HeaderBytes(const std::filesystem::path& path)
      : source_(path.string()), bytes_(kMaxHeaderBytes, '\0') {
    std::ifstream stream(path, std::ios::binary);
    stream.read(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
    bytes_.resize(static_cast<std::size_t>(stream.gcount()));
  }

  std::string_view take(std::size_t size) {
    if (size > bytes_.size() - place_) fail();
    const std::string_view taken = std::string_view(bytes_).substr(place_, size);
    place_ += size;
    return taken;
  }
  std::string_view take_name() {
    const std::size_t end = bytes_.find('\0', place_);
    if (end == std::string::npos) fail();
    const std::string_view name = take(end - place_);
    take(1);
    return name;
  }
  std::int32_t take_int() { return read_int(take(4)); }
  static std::int32_t read_int(std::string_view bytes) {
    std::int32_t value = 0;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }

 private:
  [[noreturn]] void fail() const {
    throw InputError(source_, "header", fmt::format("one that ends within {} bytes", kMaxHeaderBytes),
                     fmt::format("none in {}", bytes_.size()));
  }

  std::string source_, bytes_;
  std::size_t place_ = 0;
};

// Names with 16 bytes each, and an empty name at the very end.
bool is_channel_list(std::string_view value) {
  for (std::size_t end = value.find('\0'); end != std::string_view::npos; end = value.find('\0')) {
    if (end == 0) return value.size() == 1;
    if (value.size() < end + 17) return false;
    value.remove_prefix(end + 17);
  }
  return false;
}

// OpenEXR reads attributes of fixed size whatever size they state, and would go on in the middle of the next.
bool has_size_of_type(std::string_view type, std::string_view value) {
  constexpr std::pair<std::string_view, std::size_t> kSizes[] = {
      {"box2f", 16}, {"box2i", 16},   {"chromaticities", 32}, {"compression", 1}, {"double", 8},
      {"float", 4},  {"int", 4},      {"keycode", 28},        {"lineOrder", 1},   {"m33f", 36},
      {"m44f", 64},  {"rational", 8}, {"timecode", 8},        {"v2f", 8},         {"v2i", 8},
      {"v3f", 12},   {"v3i", 12}};
  if (type == "string") return true;
  if (type == "chlist") return is_channel_list(value);
  return std::any_of(std::begin(kSizes), std::end(kSizes),
                     [&](const auto& known) { return known.first == type && known.second == value.size(); });
}

void check_attribute(std::string_view name, std::string_view type, std::string_view value,
                     std::uintmax_t file_bytes, const std::string& source) {
  if (!has_size_of_type(type, value))
    throw InputError(source, "header", "attributes of plain types, each of its size", "another");
  if (name == "dataWindow" && type == "box2i") {
    const auto at = [&](std::size_t i) {
      return std::int64_t{HeaderBytes::read_int(value.substr(4 * i, 4))};
    };
    check_size(at(2) - at(0) + 1, at(3) - at(1) + 1, file_bytes, source);
    if (std::max(std::abs(at(0)), std::abs(at(1))) > kMaxOrigin) {
      throw InputError(source, "dataWindow",
                       fmt::format("a corner within {} pixels of the origin", kMaxOrigin),
                       fmt::format("({}, {})", at(0), at(1)));
    }
  }
  // What follows in OpenEXR's order is PXR24, B44, B44A, DWAA, DWAB.
  if (type == "compression" && static_cast<unsigned char>(value[0]) > Imf::PIZ_COMPRESSION)
    throw InputError(source, "compression", "one without loss: none, RLE, ZIPS, ZIP or PIZ", "another");
  if (name == "channels" && value.size() > kMaxChannelBytes) {
    throw InputError(source, "channels", fmt::format("a list of at most {} bytes", kMaxChannelBytes),
                     fmt::format("{}", value.size()));
  }
}

// OpenEXR takes the sizes of attributes, tiles and lines on trust and memory for all of them.
void check_header(const std::filesystem::path& path) {
  constexpr std::int32_t kMagic = 20000630, kVersion = 2, kLongNames = 0x400;
  const std::string source = path.string();
  const std::uintmax_t file_bytes = std::filesystem::file_size(path);
  HeaderBytes header(path);
  if (header.take_int() != kMagic) throw InputError(source, "", "a whole EXR file", "no EXR file");
  if (const std::int32_t version = header.take_int(); (version & ~kLongNames) != kVersion) {
    throw InputError(
        source, "version", "2, of one part and in scan lines",
        fmt::format("{}, with the flags {:#x}", version & 0xff, static_cast<unsigned>(version) >> 8));
  }
  for (std::string_view name = header.take_name(); !name.empty(); name = header.take_name()) {
    const std::string_view type = header.take_name();
    const std::int32_t size = header.take_int();
    if (size < 0) throw InputError(source, "header", "attributes with a size", fmt::format("{}", size));
    check_attribute(name, type, header.take(static_cast<std::size_t>(size)), file_bytes, source);
  }
}

HdrImage make_image(const Imf::Header& header, std::uintmax_t file_bytes, std::optional<PixelSize> wanted,
                    const std::string& source) {
  const Imath::Box2i& window = header.dataWindow();
  const auto width = std::int64_t{window.max.x} - window.min.x + 1,
             height = std::int64_t{window.max.y} - window.min.y + 1;
  check_size(width, height, file_bytes, source);
  if (wanted && (width != wanted->width || height != wanted->height)) {
    throw InputError(source, "dataWindow", fmt::format("{} x {} pixels", wanted->width, wanted->height),
                     fmt::format("{} x {}", width, height));
  }
  const bool has_luminance = header.channels().findChannel("Y") != nullptr;
  const int channels = has_luminance ? 1 : 3;
  for (const char* name : channel_names(channels)) {
    if (!header.channels().findChannel(name)) throw InputError(source, "channels", "R, G, B, or Y", "others");
  }
  int all = 0;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) ++all;
  if (wanted && all > channels)
    throw InputError(source, "channels", fmt::format("R, G, B, or Y, and no more: {}", channels),
                     fmt::format("{}", all));
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

ExrFile read_exr(const std::filesystem::path& path, std::optional<PixelSize> size) {
  check_header(path);
  Imf::InputFile input(path.c_str(), 0);
  const Imf::Header& header = input.header();
  ExrFile file{make_image(header, std::filesystem::file_size(path), size, path.string()), {}};
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

}  // namespace

ExrFile load_exr(const std::filesystem::path& path, std::optional<PixelSize> size) {
  if (!is_file(path)) throw InputError(path.string(), "", "an EXR file", "no such file");
  try {  // the boundary to a library that throws its own
    return read_exr(path, size);
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    throw InputError(path.string(), "", "a whole EXR file", error.what());
  }
}

std::string encode_exr(const HdrImage& picture, const ExrMetadata& metadata) {
  for (float value : picture.values) EQ_CHECK(std::isfinite(value), value);
  HdrImage image = picture;
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

void save_exr(const HdrImage& image, const ExrMetadata& metadata, const std::filesystem::path& path) {
  save_text(path, encode_exr(image, metadata));
}

}  // namespace equilux
