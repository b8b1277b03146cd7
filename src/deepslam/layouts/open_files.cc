#include "deepslam/layouts/open_files.h"

#include <utility>

namespace deepslam::layouts {
namespace {

// Everything that frames are read from; confidence maps stand beside their depth.
std::vector<dataset::ImagePair> HashedFiles(const FilesOfLayout& files) {
  std::vector<dataset::ImagePair> hashed = files.pairs;
  const std::vector<std::string>& confidence = files.settled.form.confidence;
  const bool has_video = files.settled.form.video != nullptr;
  for (std::size_t i = 0; i < files.pairs.size(); ++i) {
    dataset::ImagePair& pair = hashed[i];
    const dataset::TimedFile depth = pair.depth;
    if (has_video) pair.colour.file = depth.file;
    if (i >= confidence.size() || confidence[i].empty()) continue;
    hashed.push_back({{depth.time_s, confidence[i], 0}, depth});
  }
  return hashed;
}

Status AddDepthCameras(const FilesOfLayout& files,
                       const std::filesystem::path& folder,
                       dataset::Optics& optics) {
  const PinholeCamera& depth = files.settled.cameras.depth;
  if (!(files.settled.cameras.colour_from_depth == Pose3())) return Ok();
  for (const PinholeCamera& colour : optics.colour_cameras) {
    const Result<PinholeCamera> own =
        SameView(colour, {depth.width, depth.height}, folder / files.pairs.front().depth.file);
    if (!own) return own.error();
    optics.depth_cameras.push_back(*own);
  }
  return Ok();
}

}  // namespace

Result<OpenedLayout> OpenFiles(const LayoutSource& source,
                               FilesOfLayout files,
                               std::vector<std::string> warnings) {
  const std::filesystem::path& folder = source.path;
  OpenedLayout opened;
  opened.warnings = std::move(warnings);
  if (files.settled.form.video == nullptr) {
    const Status exist = dataset::CheckFilesExist(folder, files.pairs, opened.warnings);
    if (!exist) return exist.error();
  }
  opened.optics = WithStated(source.settings, files.optics);
  if (!opened.optics.colour_cameras.empty() && opened.optics.depth_cameras.empty()) {
    const Status added = AddDepthCameras(files, folder, opened.optics);
    if (!added) return added.error();
  }
  files.texts.insert(files.texts.begin(), {kSettingsName, source.settings_text});
  Result<std::string> hash = dataset::HashFiles(files.tag, files.texts, folder, HashedFiles(files));
  if (!hash) return hash.error();
  opened.content_hash = *std::move(hash);
  opened.has_times = files.has_times;
  if (!files.has_times) opened.warnings.push_back(NoTimesWarning(folder));
  opened.poses_file = std::move(files.poses_file);
  if (files.poses.empty()) files.poses.resize(files.pairs.size());
  opened.frames = dataset::MakeFileFrames(folder,
                                          files.settled.cameras,
                                          std::move(files.pairs),
                                          files.poses,
                                          std::move(files.settled.form));
  return opened;
}

}  // namespace deepslam::layouts
