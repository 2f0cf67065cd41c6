// The one file that knows libcrypto.
#include "base/digest.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <openssl/evp.h>

#include "base/error.h"

namespace equilux {
namespace {

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    EQ_CHECK(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
  }
  void update(const void* data, std::size_t size) {
    EQ_CHECK(EVP_DigestUpdate(context_.get(), data, size) == 1);
  }
  std::string finish() {
    std::array<unsigned char, 32> bytes{};
    EQ_CHECK(EVP_DigestFinal_ex(context_.get(), bytes.data(), nullptr) == 1);
    std::string hex;
    for (unsigned char byte : bytes) hex += fmt::format("{:02x}", byte);
    return hex;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_;
};

}  // namespace

std::string digest_text(std::string_view bytes) {
  Sha256 sha;
  sha.update(bytes.data(), bytes.size());
  return sha.finish();
}

std::string digest_file(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError(path.string(), "", "a readable file", std::strerror(errno));
  Sha256 sha;
  std::array<char, 1 << 16> buffer{};
  std::uintmax_t left = max_bytes;
  while (stream) {
    stream.read(buffer.data(), buffer.size());
    const auto count = static_cast<std::uintmax_t>(stream.gcount());
    if (count > left) throw InputError(path.string(), "", fmt::format("at most {} bytes", max_bytes), "more");
    left -= count;
    sha.update(buffer.data(), static_cast<std::size_t>(count));
  }
  if (stream.bad()) throw InputError(path.string(), "", "a readable file", std::strerror(errno));
  return sha.finish();
}

}  // namespace equilux
