// Renamed keys and values of documents: table entries and the warning about an old name.
#pragma once

#include <string>
#include <string_view>

namespace firn {

// An old name and its current name, in the tables or objects at a path of one kind of document.
template <class Document>
struct Alias {
  Document document;
  std::string_view path;  // in current names: "stages[].motors[]", "shapes.*"; empty: the root
  std::string_view old_name, name;
  std::string_view key =
      {};  // current name of the key whose text value is renamed; empty: a key is renamed
};

// One use of an old name.
struct OldNameUse {
  std::string path;  // of the key; elements of arrays by index; empty: the place names it
  unsigned line = 0;
  std::string old_name, name;
  bool both = false;  // the table has the current name as well
};

// `"OLD" is now "NAME"; the old name is read by this version only`
std::string old_name_warning(std::string_view old_name, std::string_view name);

// Prints "firn: warning: PLACE: PATH: ..." on standard error, once per place and key.
void warn_of_old_name(const std::string& place, const OldNameUse& use);

}  // namespace firn
