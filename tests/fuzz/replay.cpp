// Without libFuzzer: every file of a corpus once through its target.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace {
namespace fs = std::filesystem;

std::vector<fs::path> list_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code missing;
  for (const auto& entry : fs::directory_iterator(folder, missing)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// False, with a line that names the file, if the target lets anything but a refusal out.
bool replay(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  try {
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    return true;
  } catch (const std::exception& error) {
    std::printf("%s: %s\n", file.c_str(), error.what());
    return false;
  }
}

}  // namespace

int main(int argument_count, char** arguments) {
  const std::vector<fs::path> files =
      argument_count == 2 ? list_files(arguments[1]) : std::vector<fs::path>();
  if (files.empty()) {
    std::printf("expected a folder with at least one file, got none\n");
    return 1;
  }
  std::size_t faults = 0;
  for (const fs::path& file : files) faults += !replay(file);
  std::printf("%zu files, %zu faults\n", files.size(), faults);
  return faults > 0;
}
