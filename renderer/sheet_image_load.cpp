// Finds and loads the module of sheet_image.cpp.
#include <dlfcn.h>

#include "base/error.h"
#include "base/files.h"
#include "renderer/sheet_image.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

void check_font(const fs::path& path) {
  if (!is_file(path))
    throw InputError(path.string(), "", "the font DejaVu Sans, Debian package fonts-dejavu-core",
                     "no such file");
}

fs::path module_path() { return fs::read_symlink("/proc/self/exe").parent_path() / "equilux_sheet_image.so"; }

// Stays loaded to the end: its libraries are not made to be unloaded.
const SheetImage& load_module() {
  const fs::path path = module_path();
  void* module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* symbol = module ? ::dlsym(module, "equilux_sheet_image") : nullptr;
  if (!symbol) throw InputError(path.string(), "", "the module that draws sheets", ::dlerror());
  return *static_cast<const SheetImage*>(symbol);
}

}  // namespace

const SheetImage& load_sheet_image() {
  for (const bool bold : {false, true}) check_font(sheet_font_path(bold));
  static const SheetImage& image = load_module();
  return image;
}

}  // namespace equilux
