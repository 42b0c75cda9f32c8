// The tree of frames that a bag's /tf and /tf_static tell.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mapping/io/bag_file.h"
#include "mapping/io/recorded_poses.h"

namespace atlas::mapping {

/// The name without a leading slash, with which ROS 1 names some frames; fit for a line to the user.
std::string FrameName(const std::string& frame);

class BagTransforms {
 public:
  /// The transforms of the bag's topics that end in tf_static and, where named, of `moving_topic`. `file` is
  /// the bag's name in errors. @throws InputError.
  BagTransforms(const BagFile& bag, const std::string& file, const std::string& moving_topic = "");

  /// The pose of frame `to` in frame `from` by the transforms that never change, where they lead there.
  std::optional<core::Pose> Static(const std::string& from, const std::string& to) const;

  /// The poses of `frame` in the root of its tree, at the times of the transform on the way that is told most
  /// often; the others are interpolated. @throws InputError where nothing on the way moves.
  RecordedPoses OfFrame(const std::string& frame) const;

 private:
  struct Edge {
    std::string parent;
    RecordedPoses T_parent_child;  ///< by time; of a static transform one, at zero
    bool is_static = false;
  };
  std::vector<const Edge*> ToRoot(std::string frame, std::string* root) const;

  std::string file_;
  std::map<std::string, Edge> edge_of_child_;
};

}  // namespace atlas::mapping
