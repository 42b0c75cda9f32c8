// Things chosen by name: a table of entries, each with `name`, `doc` and how it is built. The tables are made
// of the catalog.inc beside them, a line an entry.
#pragma once

#include <string>
#include <vector>

#include "core/errors.h"

namespace atlas::core {

template <typename Entry>
std::vector<std::string> NamesOf(const std::vector<Entry>& catalog) {
  std::vector<std::string> names;
  for (const Entry& entry : catalog) names.push_back(entry.name);
  return names;
}

/// Null where there is none of that name.
template <typename Entry>
const Entry* FindEntry(const std::vector<Entry>& catalog, const std::string& name) {
  for (const Entry& entry : catalog) {
    if (entry.name == name) return &entry;
  }
  return nullptr;
}

/// `kind` is what entries are called in messages. @throws InputError for an unknown name, with the near one.
template <typename Entry>
const Entry& EntryNamed(const std::vector<Entry>& catalog, const std::string& kind, const std::string& name) {
  if (const Entry* entry = FindEntry(catalog, name)) return *entry;
  throw InputError(UnknownName(kind, name, NamesOf(catalog)));
}

}  // namespace atlas::core
