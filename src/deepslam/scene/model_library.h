// A library of whole models for retrieval: canonical shapes with class, real size and credit.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/scene/voxel_grid.h"

namespace deepslam {

struct LibraryModel {
  std::string id;    // "kator_legaz/123"; letters, digits, '_', '-' and one '/'; unique and stable
  std::string name;  // the catalogue's name, for people
  std::string class_name;  // of the class table
  Eigen::Vector3d size_m =
      Eigen::Vector3d::Zero();  // real extent along object x (front), y (left), z (up)
  std::string creator;
  std::string licence;
  VoxelGrid shape;
  std::string checksum;  // sha256 of the shape's bytes
};

struct ModelLibrary {
  std::vector<LibraryModel> models;  // ascending id
  std::string checksum;              // of the whole library
};

}  // namespace deepslam
