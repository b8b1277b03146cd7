#include "deepslam/dataset/load_video_module.h"

#include <dlfcn.h>

#include <fmt/format.h>

#include "deepslam/video/video_module.h"

namespace deepslam::dataset {
namespace {

Error NotLoaded(const std::string& file, const std::string& fault) {
  return Failed(
      fmt::format("videos need {}, which cannot be loaded ({}); it is looked for in lib/deepslam "
                  "beside the program's folder, in LD_LIBRARY_PATH and among the system's "
                  "libraries: install deepslam anew, or give the video's frames as images",
                  file,
                  fault));
}

}  // namespace

Result<const video::VideoModule*> LoadVideoModule(const std::string& file) {
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return NotLoaded(file, dlerror());
  auto* const entry = reinterpret_cast<video::ModuleEntry*>(dlsym(library, video::kModuleEntry));
  if (entry == nullptr) return NotLoaded(file, fmt::format("it has no {}", video::kModuleEntry));
  const video::VideoModule* const module = entry();
  if (module->version != video::VideoModule::kVersion) {
    return NotLoaded(file,
                     fmt::format("it is of another build: version {}, not {}",
                                 module->version,
                                 video::VideoModule::kVersion));
  }
  return module;
}

}  // namespace deepslam::dataset
