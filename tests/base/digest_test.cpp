// SHA-256 against the known answers of FIPS 180-2.
#include "base/digest.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::HasSubstr;

TEST(Digest, GivesTheKnownAnswers) {
  EXPECT_EQ(digest_text(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(digest_text("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(digest_text("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(digest_text(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Digest, OfAFileIsThatOfItsBytesAtAnySize) {
  const TempFolder folder;
  for (std::size_t size : {0u, 1u, 65535u, 65536u, 65537u, 200000u}) {
    std::string bytes;
    for (std::size_t i = 0; i < size; ++i) bytes += static_cast<char>(i * 7 % 251);
    EXPECT_EQ(digest_file(folder.write("file", bytes)), digest_text(bytes)) << size;
  }
}

TEST(Digest, OfAFileLargerThanItMayBeIsAnError) {
  const TempFolder folder;
  const auto file = folder.write("file", std::string(65537, 'a'));
  EXPECT_EQ(digest_file(file, 65537), digest_file(file));
  EXPECT_THAT(message_of<InputError>([&] { digest_file(file, 65536); }),
              HasSubstr("expected at most 65536 bytes, got more"));
}

TEST(Digest, OfAMissingFileOrAFolderIsAnErrorThatNamesIt) {
  const TempFolder folder;
  const auto missing = folder / "missing";
  EXPECT_THAT(message_of<InputError>([&] { digest_file(missing); }), HasSubstr(missing.string()));
  EXPECT_THAT(message_of<InputError>([&] { digest_file(folder.path()); }), HasSubstr(folder.path().string()));
}

}  // namespace
}  // namespace equilux
