#include "deepslam/gltf/gltf_document.h"

#include <string>
#include <utility>

#include "deepslam/gltf/glb_container.h"

namespace deepslam::gltf {
namespace {

std::optional<GltfDocument> Open(const GlbChunks& chunks, Findings& findings) {
  std::optional<GltfJson> json = GltfJson::Parse(chunks.json, findings);
  if (!json) return std::nullopt;
  const JsonPlace place = json->root()["asset"]["version"];
  const std::string version = place.Text();
  const std::string what = "is '" + version + "', expected 2.0; export as glTF 2.0";
  if (!version.starts_with("2.")) {
    place.Error(what);
  } else if (version != "2.0") {
    place.Breach(what);
  }
  return GltfDocument{*std::move(json), chunks.binary};
}

}  // namespace

std::optional<GltfDocument> OpenGlb(std::string_view bytes, Findings& findings) {
  const std::optional<GlbChunks> chunks = ReadGlbChunks(bytes, findings);
  return chunks ? Open(*chunks, findings) : std::nullopt;
}

std::optional<GltfDocument> OpenGlbOrGltf(std::string_view bytes, Findings& findings) {
  return bytes.starts_with("glTF") ? OpenGlb(bytes, findings) : Open({bytes, {}}, findings);
}

}  // namespace deepslam::gltf
