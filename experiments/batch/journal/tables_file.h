// Databases of journals and run caches: files with tables of one format.
#pragma once

#include <string>

#include "experiments/storage/sqlite_file.h"

namespace firn {

using sqlite::Statement;
using sqlite::Transaction;

// Every failure of SQLite is a RunError that names the file and leaves the data unchanged.
class Database : public sqlite::File {
 public:
  // Opens or creates the file, and creates missing tables of `schema`. Throws InputError when it
  // cannot be opened, is not a database, or has another format.
  Database(const std::string& file, const std::string& schema, int format);
  // Opens an existing file for reading only. Throws InputError as above.
  Database(const std::string& file, int format);

 private:
  void set_up(const std::string& schema, int format);
  void require_format(int format);
};

}  // namespace firn
