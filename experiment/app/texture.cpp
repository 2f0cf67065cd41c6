// Copies instead of drawing: a blit has no sampling position that could fall between two pixels.
#include "experiment/app/texture.h"

#include <utility>

#include "base/error.h"
#include "experiment/app/gl.h"

namespace equilux {
namespace {

// GL counts rows from the bottom, pictures from the top.
void upload(const LdrImage& image) {
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, image.width, image.height, 0, GL_RGB, GL_UNSIGNED_BYTE, nullptr);
  const std::size_t row_bytes = static_cast<std::size_t>(image.width) * 3;
  for (int row = 0; row < image.height; ++row) {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, image.height - 1 - row, image.width, 1, GL_RGB, GL_UNSIGNED_BYTE,
                    image.values.data() + static_cast<std::size_t>(row) * row_bytes);
  }
}

}  // namespace

Texture::Texture(const LdrImage& image) : size_{image.width, image.height} {
  glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  upload(image);
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture_, 0);
  const unsigned status = glCheckFramebufferStatus(GL_READ_FRAMEBUFFER);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  glBindTexture(GL_TEXTURE_2D, 0);
  EQ_CHECK(status == GL_FRAMEBUFFER_COMPLETE, status, image.width, image.height);
}

Texture::~Texture() {
  glDeleteFramebuffers(1, &framebuffer_);
  glDeleteTextures(1, &texture_);
}

Texture::Texture(Texture&& other) noexcept
    : texture_(std::exchange(other.texture_, 0)),
      framebuffer_(std::exchange(other.framebuffer_, 0)),
      size_(other.size_) {}

Texture& Texture::operator=(Texture&& other) noexcept {
  std::swap(texture_, other.texture_);
  std::swap(framebuffer_, other.framebuffer_);
  std::swap(size_, other.size_);
  return *this;
}

void Texture::draw(const Rectangle& place, Size framebuffer) const {
  EQ_CHECK(place.width == size_.width && place.height == size_.height, place.width, place.height, size_.width,
           size_.height);
  const int bottom = framebuffer.height - place.y - place.height;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glBlitFramebuffer(0, 0, size_.width, size_.height, place.x, bottom, place.x + place.width,
                    bottom + place.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
}

}  // namespace equilux
