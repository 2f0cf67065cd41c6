// A picture in the graphics card, copied to the screen pixel for pixel.
#pragma once

#include <cstdint>

#include "experiment/app/layout.h"
#include "stimuli/image.h"

namespace equilux {

/// Needs a current GL context for as long as it lives.
class Texture {
 public:
  explicit Texture(const LdrImage& image);
  ~Texture();
  Texture(Texture&& other) noexcept;
  Texture& operator=(Texture&& other) noexcept;

  /// Copies every pixel to one pixel of the back buffer: no filter, no blending, no colour conversion.
  /// `place` has the picture's size.
  void draw(const Rectangle& place, Size framebuffer) const;

  /// For Dear ImGui; rows are stored from the bottom.
  void* id() const { return reinterpret_cast<void*>(static_cast<std::uintptr_t>(texture_)); }

 private:
  unsigned texture_ = 0;
  unsigned framebuffer_ = 0;  ///< reads from the texture
  Size size_;
};

}  // namespace equilux
