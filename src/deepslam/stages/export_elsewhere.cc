#include "deepslam/stages/export_elsewhere.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "deepslam/presentation/rigid_bodies.h"
#include "deepslam/presentation/scenes_elsewhere.h"
#include "deepslam/usd/usda_writer.h"
#include "deepslam/usd/usdz.h"

namespace deepslam::stages {
namespace {

Status WriteUsd(const usd::UsdScene& scene,
                std::string_view kind,
                const simulator::WriteFile& write) {
  Result<std::string> usda = usd::WriteUsda(scene);
  if (!usda.ok()) return usda.error();
  if (kind != "usdz") {
    if (Status status = write("scene.usda", *usda); !status.ok()) return status;
  }
  if (kind == "usda") return Ok();
  const std::array<usd::PackagedFile, 1> files = {{{"scene.usda", std::move(usda).value()}}};
  const Result<std::string> usdz = usd::WriteUsdz(files);
  return usdz.ok() ? write("scene.usdz", *usdz) : Status(usdz.error());
}

}  // namespace

Status WriteElsewhere(const ExportedScene& exported,
                      const Config& config,
                      const simulator::WriteFile& write) {
  const ExportStageOptions& wanted = config.export_stage;
  const bool with_usd = wanted.usd != "none";
  std::optional<presentation::RigidBodies> bodies;
  if (wanted.simulator || (with_usd && wanted.usd_physics)) {
    bodies = presentation::MakeRigidBodies(
        exported.map, exported.meshes, exported.scene.parts, exported.classes, config.convex);
  }
  Status status = Ok();
  if (with_usd) {
    const presentation::RigidBodies* in_usd = wanted.usd_physics ? &*bodies : nullptr;
    status =
        WriteUsd(presentation::UsdSceneOf(exported.scene, exported.map, in_usd), wanted.usd, write);
  }
  if (!wanted.simulator || !status.ok()) return status;
  return simulator::WriteSimulatorFiles(
      presentation::SimulatorSceneOf(exported.scene, exported.map, *bodies),
      [&](std::string_view file, std::string_view bytes) {
        return write("simulator/" + std::string(file), bytes);
      });
}

}  // namespace deepslam::stages
