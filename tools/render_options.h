// Options of the command line that say which models training views are rendered of, and how.
#pragma once

#include <string>
#include <vector>

#include "render_shards.h"
#include "training_models.h"

namespace CLI {
class App;
}

namespace deepslam::tools {

void AddClassOption(CLI::App& command, std::vector<std::string>& classes);
void AddModelOptions(CLI::App& command, TrainingModelRequest& models);
// The seed is that of the models as well.
void AddViewOptions(CLI::App& command, RenderRequest& render);

}  // namespace deepslam::tools
