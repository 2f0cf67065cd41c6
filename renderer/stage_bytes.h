// Values of a stage as bytes and back, bit for bit; runs of zeros as their length, since most pixels of a
// pilot or a check are black.
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "base/error.h"
#include "stimuli/image.h"

namespace equilux {

template <typename T>
concept Number = std::is_arithmetic_v<T>;

/// A struct whose members are told, in order, by `members(value)`: a tuple of references.
template <typename T>
concept HasMembers = requires(T& value) {
  members(value);
};

/// Of either constness, for overloads of `members`.
template <typename T, typename Struct>
concept Is = std::same_as<std::remove_const_t<T>, Struct>;

class StageWriter {
 public:
  template <Number T>
  void write(T value) {
    append(&value, 1);
  }
  void write(const std::string& text) {
    write(text.size());
    bytes_ += text;
  }
  void write(const HdrImage& image) {
    write(image.width);
    write(image.height);
    write(image.channels);
    write(image.values);
  }
  template <Number T>
  void write(const std::vector<T>& numbers) {
    write(numbers.size());
    for (std::size_t at = 0; at < numbers.size();) {
      const std::size_t first = find_end(numbers, at, true), end = find_literals_end(numbers, first);
      write(first - at);
      write(end - first);
      append(numbers.data() + first, end - first);
      at = end;
    }
  }
  template <typename T>
  void write(const std::vector<T>& items) {
    write(items.size());
    for (const T& item : items) write(item);
  }
  template <typename T>
  void write(const std::optional<T>& value) {
    write(value.has_value());
    if (value) write(*value);
  }
  template <HasMembers T>
  void write(const T& value) {
    std::apply([&](const auto&... member) { (write(member), ...); }, members(value));
  }
  std::string take() { return std::move(bytes_); }

 private:
  // Shorter ones cost more than they spare.
  static constexpr std::size_t kLeastRun = 8;

  template <Number T>
  void append(const T* values, std::size_t count) {
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }
  // Of those that are zero in all bits, or of the others.
  template <Number T>
  static std::size_t find_end(const std::vector<T>& numbers, std::size_t at, bool zeros) {
    constexpr T kZero{};
    const auto is_zero = [&](std::size_t i) { return std::memcmp(&numbers[i], &kZero, sizeof(T)) == 0; };
    while (at < numbers.size() && is_zero(at) == zeros) ++at;
    return at;
  }
  template <Number T>
  static std::size_t find_literals_end(const std::vector<T>& numbers, std::size_t at) {
    while (true) {
      const std::size_t end = find_end(numbers, at, false), next = find_end(numbers, end, true);
      if (next == numbers.size() || next - end >= kLeastRun) return end;
      at = next;
    }
  }

  std::string bytes_;
};

/// Reads what a StageWriter wrote. Takes no memory before it knows that numbers are as many as pixels, or
/// that items have bytes. errors: InputError naming `source`, for what cannot be of pictures of `size`
class StageReader {
 public:
  StageReader(std::string_view bytes, PixelSize size, std::string source)
      : left_(bytes), size_(size), source_(std::move(source)) {}

  template <Number T>
  void read(T& value) {
    take(&value, 1);
  }
  // Neither 0 nor 1 is a bool of its own.
  void read(bool& value) {
    unsigned char byte = 0;
    take(&byte, 1);
    if (byte > 1) refuse("0 or 1");
    value = byte == 1;
  }
  void read(std::string& text) {
    text.resize(take_count(1));
    take(text.data(), text.size());
  }
  void read(HdrImage& image) {
    read(image.width);
    read(image.height);
    read(image.channels);
    const bool is_none = image.width == 0 && image.height == 0;
    if (!is_none && PixelSize{image.width, image.height} != size_) refuse("an image of the study's size");
    if (image.channels != 1 && image.channels != 3) refuse("1 or 3 channels");
    read_numbers(image.values, image.pixel_count() * static_cast<std::size_t>(image.channels));
    for (const float value : image.values) {
      if (!std::isfinite(value)) refuse("finite values");
    }
  }
  /// A value for each pixel, or none.
  template <Number T>
  void read(std::vector<T>& numbers) {
    StageReader ahead = *this;
    std::size_t count = 0;
    ahead.read(count);
    read_numbers(numbers, count == 0 ? 0 : count_pixels());
  }
  template <typename T>
  void read(std::vector<T>& items) {
    items.resize(take_count(sizeof(T) < 64 ? 1 : 8));
    for (T& item : items) read(item);
  }
  template <typename T>
  void read(std::optional<T>& value) {
    bool has_value = false;
    read(has_value);
    if (has_value) read(value.emplace());
  }
  template <HasMembers T>
  void read(T& value) {
    std::apply([&](auto&... member) { (read(member), ...); }, members(value));
  }
  void expect_end() const {
    if (!left_.empty()) refuse("the end");
  }
  std::string_view left() const { return left_; }
  std::size_t count_pixels() const {
    return static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(size_.height);
  }
  [[noreturn]] void refuse(const std::string& expected) const {
    throw InputError(source_, fmt::format("{} bytes before its end", left_.size()), expected,
                     "another value");
  }

 private:
  template <typename T>
  void take(T* values, std::size_t count) {
    if (count > left_.size() / sizeof(T)) refuse("more bytes");
    if (count > 0) std::memcpy(values, left_.data(), count * sizeof(T));
    left_.remove_prefix(count * sizeof(T));
  }
  // Of items that have so many bytes or more.
  std::size_t take_count(std::size_t least_bytes) {
    std::size_t count = 0;
    read(count);
    if (count > left_.size() / least_bytes) refuse("as many items as there are bytes for");
    return count;
  }
  template <Number T>
  void read_numbers(std::vector<T>& numbers, std::size_t expected) {
    std::size_t count = 0;
    read(count);
    if (count != expected) refuse(fmt::format("{} numbers", expected));
    numbers.assign(count, T{});
    for (std::size_t at = 0; at < count;) {
      std::size_t zeros = 0, literals = 0;
      read(zeros);
      read(literals);
      if (zeros > count - at || literals > count - at - zeros || zeros + literals == 0)
        refuse("runs that fill the numbers");
      take(numbers.data() + at + zeros, literals);
      at += zeros + literals;
    }
  }

  std::string_view left_;
  PixelSize size_;
  std::string source_;
};

}  // namespace equilux
