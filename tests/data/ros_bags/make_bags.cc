// Writes none.bag, bz2.bag and lz4.bag beside it with ROS's own library and message types, so that the reader
// of bags is tested against files that it had no part in. Not built with the project:
//
//   apt-get install librosbag-storage-dev libsensor-msgs-dev libnav-msgs-dev libtf2-msgs-dev
//   g++ -std=c++17 make_bags.cc -o make_bags -I/usr/include/{pluginlib,class_loader,ament_index_cpp} \
//     -I/usr/include/{rcpputils,rcutils} -lrosbag_storage -lcpp_common -lrostime -lroscpp_serialization \
//     -lconsole_bridge -lboost_system && ./make_bags
//
// /points: three organised scans of 2 x 5 points, t in nanoseconds, ring, rows longer than their points.
// /dense: two clouds of float64, big endian, without rings. /odom: base_link; /tf_static: its LiDAR.
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace {

sensor_msgs::PointField Field(const char* name, uint32_t offset, uint8_t type) {
  sensor_msgs::PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = type;
  field.count = 1;
  return field;
}

template <typename T>
void Put(sensor_msgs::PointCloud2* cloud, size_t at, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (cloud->is_bigendian) std::reverse(raw, raw + sizeof(T));
  std::memcpy(cloud->data.data() + at, raw, sizeof(T));
}

/// Scan k, point i: x = i + 1, y = 10 k, z = row; i divisible by 4: no return.
sensor_msgs::PointCloud2 Organised(int k, ros::Time stamp) {
  using F = sensor_msgs::PointField;
  sensor_msgs::PointCloud2 cloud;
  cloud.header.stamp = stamp;
  cloud.header.frame_id = "lidar";
  cloud.height = 2;
  cloud.width = 5;
  cloud.fields = {Field("x", 0, F::FLOAT32), Field("y", 4, F::FLOAT32),
                  Field("z", 8, F::FLOAT32), Field("intensity", 16, F::FLOAT32),
                  Field("t", 20, F::UINT32), Field("ring", 24, F::UINT16)};
  cloud.point_step = 32;
  cloud.row_step = 5 * 32 + 16;
  cloud.data.resize(2 * cloud.row_step, 0xee);
  for (int row = 0, i = 0; row < 2; ++row) {
    for (int column = 0; column < 5; ++column, ++i) {
      const size_t at = row * cloud.row_step + column * cloud.point_step;
      Put(&cloud, at, i % 4 == 0 ? NAN : i + 1.0f);
      Put(&cloud, at + 4, i % 4 == 0 ? NAN : 10.0f * k);
      Put(&cloud, at + 8, i % 4 == 0 ? NAN : static_cast<float>(row));
      Put(&cloud, at + 20, static_cast<uint32_t>(20000000 * column));
      Put(&cloud, at + 24, static_cast<uint16_t>(row));
    }
  }
  return cloud;
}

/// Point i: (i, -i, 0.25 k).
sensor_msgs::PointCloud2 Dense(int k, ros::Time stamp) {
  using F = sensor_msgs::PointField;
  sensor_msgs::PointCloud2 cloud;
  cloud.header.stamp = stamp;
  cloud.header.frame_id = "lidar";
  cloud.is_bigendian = true;
  cloud.height = 1;
  cloud.width = 7;
  cloud.fields = {Field("x", 0, F::FLOAT64), Field("y", 8, F::FLOAT64), Field("z", 16, F::FLOAT64)};
  cloud.point_step = 24;
  cloud.row_step = 7 * 24;
  cloud.data.resize(cloud.row_step);
  for (int i = 0; i < 7; ++i) {
    Put(&cloud, i * 24, static_cast<double>(i));
    Put(&cloud, i * 24 + 8, -static_cast<double>(i));
    Put(&cloud, i * 24 + 16, 0.25 * k);
  }
  return cloud;
}

void Write(const char* name, rosbag::CompressionType compression) {
  rosbag::Bag bag(name, rosbag::bagmode::Write);
  bag.setCompression(compression);
  bag.setChunkThreshold(800);
  tf2_msgs::TFMessage fixed;
  geometry_msgs::TransformStamped T;
  T.header.frame_id = "base_link";
  T.child_frame_id = "lidar";
  T.transform.translation.x = 0.3;
  T.transform.rotation.z = T.transform.rotation.w = std::sqrt(0.5);
  fixed.transforms.push_back(T);
  bag.write("/tf_static", ros::Time(1600000000, 0), fixed);
  for (int k = 0; k < 3; ++k) {
    const ros::Time stamp(1600000000 + k, 500000000), recorded = stamp + ros::Duration(0.125);
    nav_msgs::Odometry odometry;
    odometry.header.stamp = stamp;
    odometry.header.frame_id = "odom";
    odometry.child_frame_id = "base_link";
    odometry.pose.pose.position.x = 2.0 * k;
    odometry.pose.pose.orientation.w = 1.0;
    bag.write("/odom", recorded, odometry);
    bag.write("/points", recorded, Organised(k, stamp));
    if (k < 2) bag.write("/dense", recorded, Dense(k, stamp));
  }
}

}  // namespace

int main() {
  Write("none.bag", rosbag::compression::Uncompressed);
  Write("bz2.bag", rosbag::compression::BZ2);
  Write("lz4.bag", rosbag::compression::LZ4);
}
