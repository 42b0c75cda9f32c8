// The XML of robots' files.
#pragma once

#include <boost/property_tree/ptree.hpp>
#include <filesystem>

namespace atlas::robots {

/// Elements, attributes and text of a file. @throws InputError for a missing file, malformed XML or elements
/// nested too deeply: file, line, limit.
boost::property_tree::ptree ReadXml(const std::filesystem::path& file);

}  // namespace atlas::robots
