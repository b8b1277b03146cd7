#include "deepslam/gltf/tiny_gltf_check.h"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_ENABLE_DRACO
#define TINYGLTF_NO_INCLUDE_JSON
#include <tiny_gltf.h>

namespace deepslam::gltf {

std::string LoadByTinyGltf(std::string_view bytes) {
  tinygltf::TinyGLTF loader;
  tinygltf::Model model;
  std::string error;
  std::string warning;
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  const bool loaded = loader.LoadBinaryFromMemory(
      &model, &error, &warning, data, static_cast<unsigned int>(bytes.size()));
  if (!loaded && error.empty()) return "cannot be loaded";
  return error + warning;
}

}  // namespace deepslam::gltf
