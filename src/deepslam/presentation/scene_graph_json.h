// export/scene_graph.json, as docs/scene_graph.schema.json describes it. Written for other programs
// alone: what deepslam reads is the compact map.
#pragma once

#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/presentation/scene_graph.h"

namespace deepslam::presentation {

// Keys are sorted. Error: a number that is not finite. `name` is what messages call the file.
[[nodiscard]] Result<std::string> EncodeSceneGraph(const SceneGraph& graph, std::string_view name);

}  // namespace deepslam::presentation
