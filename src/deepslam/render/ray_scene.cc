#include "deepslam/render/ray_scene.h"

#include <algorithm>
#include <cstring>
#include <string>

#include <embree3/rtcore.h>

#include "deepslam/core/parallel.h"

namespace deepslam::render {
namespace {

constexpr std::size_t kPacketRays = 8;  // of a packet of rays

}  // namespace

struct RayScene::Impl {
  // Without "threads": that setting bounds every TBB loop of the process while the device lives.
  RTCDevice device = rtcNewDevice("set_affinity=0");
  RTCScene scene = nullptr;
  int num_instances = 0;
  bool committed = false;

  Impl() {
    DEEPSLAM_CHECK(device != nullptr, "Embree gives no device");
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  }
  ~Impl() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
};

RayScene::RayScene() : impl_(std::make_unique<Impl>()) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

Result<int> RayScene::AddMesh(const TriangleMesh& mesh, const Pose3& world_from_mesh) {
  DEEPSLAM_CHECK(!impl_->committed, "AddMesh after Commit");
  if (mesh.empty()) return InvalidInput("mesh has no faces");
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const std::uint32_t corner : mesh.faces[f]) {
      if (corner >= mesh.vertices.size()) {
        return InvalidInput("face " + std::to_string(f) + " names vertex " +
                            std::to_string(corner) + " of " + std::to_string(mesh.vertices.size()));
      }
    }
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!mesh.vertices[v].allFinite())
      return InvalidInput("vertex " + std::to_string(v) + " is not finite");
  }
  const RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry,
                                                               RTC_BUFFER_TYPE_VERTEX,
                                                               0,
                                                               RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float),
                                                               mesh.vertices.size()));
  auto* faces = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(geometry,
                                                                    RTC_BUFFER_TYPE_INDEX,
                                                                    0,
                                                                    RTC_FORMAT_UINT3,
                                                                    3 * sizeof(std::uint32_t),
                                                                    mesh.faces.size()));
  DEEPSLAM_CHECK(vertices != nullptr && faces != nullptr, "Embree gives no memory for a mesh");
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    const Eigen::Vector3f p_world = (world_from_mesh * vertex.cast<double>()).cast<float>();
    std::memcpy(vertices, p_world.data(), 3 * sizeof(float));
    vertices += 3;
  }
  std::memcpy(faces, mesh.faces.data(), mesh.faces.size() * sizeof(mesh.faces[0]));
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(impl_->scene, geometry, static_cast<unsigned>(impl_->num_instances));
  rtcReleaseGeometry(geometry);
  return impl_->num_instances++;
}

void RayScene::Commit() {
  // The tree, and with it which of two equally near faces is hit, must not depend on timing.
  OnOneThread([this] { rtcCommitScene(impl_->scene); });
  impl_->committed = true;
}

int RayScene::num_instances() const { return impl_->num_instances; }

std::optional<RayHit> RayScene::Cast(const Eigen::Vector3f& origin,
                                     const Eigen::Vector3f& direction,
                                     float min_m,
                                     float max_m) const {
  DEEPSLAM_CHECK(impl_->committed, "Cast before Commit");
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query{};
  query.ray.org_x = origin.x();
  query.ray.org_y = origin.y();
  query.ray.org_z = origin.z();
  query.ray.dir_x = direction.x();
  query.ray.dir_y = direction.y();
  query.ray.dir_z = direction.z();
  query.ray.tnear = min_m;
  query.ray.tfar = max_m;
  query.ray.mask = 0xFFFFFFFFu;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  Eigen::Vector3f normal(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z);
  normal.normalize();
  if (normal.dot(direction) > 0) normal = -normal;
  return RayHit{static_cast<double>(query.ray.tfar),
                normal,
                static_cast<int>(query.hit.geomID),
                query.hit.primID,
                query.hit.u,
                query.hit.v};
}

void RayScene::CastFan(const Eigen::Vector3f& origin,
                       std::span<const Eigen::Vector3f> directions,
                       std::span<RayHit> hits) const {
  DEEPSLAM_CHECK(impl_->committed, "CastFan before Commit");
  DEEPSLAM_CHECK(hits.size() == directions.size(), "a hit for each direction");
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (std::size_t first = 0; first < directions.size(); first += kPacketRays) {
    RTCRayHit8 query{};
    alignas(32) int valid[kPacketRays];
    const std::size_t count = std::min(kPacketRays, directions.size() - first);
    for (std::size_t i = 0; i < kPacketRays; ++i) {
      valid[i] = i < count ? -1 : 0;
      const Eigen::Vector3f& direction = directions[first + std::min(i, count - 1)];
      query.ray.org_x[i] = origin.x();
      query.ray.org_y[i] = origin.y();
      query.ray.org_z[i] = origin.z();
      query.ray.dir_x[i] = direction.x();
      query.ray.dir_y[i] = direction.y();
      query.ray.dir_z[i] = direction.z();
      query.ray.tfar[i] = 1e6f;
      query.ray.mask[i] = 0xFFFFFFFFu;
      query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(valid, impl_->scene, &context, &query);
    for (std::size_t i = 0; i < count; ++i) {
      RayHit& hit = hits[first + i];
      hit = RayHit();
      if (query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      Eigen::Vector3f normal(query.hit.Ng_x[i], query.hit.Ng_y[i], query.hit.Ng_z[i]);
      normal.normalize();
      if (normal.dot(directions[first + i]) > 0) normal = -normal;
      hit = {static_cast<double>(query.ray.tfar[i]),
             normal,
             static_cast<int>(query.hit.geomID[i]),
             query.hit.primID[i],
             query.hit.u[i],
             query.hit.v[i]};
    }
  }
}

bool RayScene::Occluded(const Eigen::Vector3f& from,
                        const Eigen::Vector3f& to,
                        float margin_m) const {
  DEEPSLAM_CHECK(impl_->committed, "Occluded before Commit");
  const Eigen::Vector3f way = to - from;
  const float length_m = way.norm();
  if (length_m <= 2 * margin_m) return false;
  const Eigen::Vector3f direction = way / length_m;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray{};
  ray.org_x = from.x();
  ray.org_y = from.y();
  ray.org_z = from.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tnear = margin_m;
  ray.tfar = length_m - margin_m;
  ray.mask = 0xFFFFFFFFu;
  rtcOccluded1(impl_->scene, &context, &ray);
  return ray.tfar < 0;
}

void RayScene::AreOccluded(std::span<const Eigen::Vector3f> from,
                           std::span<const Eigen::Vector3f> to,
                           std::span<std::uint8_t> occluded,
                           float margin_m) const {
  DEEPSLAM_CHECK(impl_->committed, "AreOccluded before Commit");
  DEEPSLAM_CHECK(from.size() == to.size() && to.size() == occluded.size(), "an answer for each");
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (std::size_t first = 0; first < from.size(); first += kPacketRays) {
    RTCRay8 rays{};
    alignas(32) int valid[kPacketRays];
    const std::size_t count = std::min(kPacketRays, from.size() - first);
    for (std::size_t i = 0; i < kPacketRays; ++i) {
      const std::size_t n = first + std::min(i, count - 1);
      const Eigen::Vector3f way = to[n] - from[n];
      const float length_m = way.norm();
      const Eigen::Vector3f direction = way / length_m;
      valid[i] = i < count && length_m > 2 * margin_m ? -1 : 0;
      rays.org_x[i] = from[n].x();
      rays.org_y[i] = from[n].y();
      rays.org_z[i] = from[n].z();
      rays.dir_x[i] = direction.x();
      rays.dir_y[i] = direction.y();
      rays.dir_z[i] = direction.z();
      rays.tnear[i] = margin_m;
      rays.tfar[i] = length_m - margin_m;
      rays.mask[i] = 0xFFFFFFFFu;
    }
    rtcOccluded8(valid, impl_->scene, &context, &rays);
    for (std::size_t i = 0; i < count; ++i)
      occluded[first + i] = valid[i] != 0 && rays.tfar[i] < 0 ? 1 : 0;
  }
}

}  // namespace deepslam::render
