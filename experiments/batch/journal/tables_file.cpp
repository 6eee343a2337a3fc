#include "experiments/batch/journal/tables_file.h"

#include <fmt/format.h>

#include "experiments/system/output_file.h"

namespace firn {

Database::Database(const std::string& file, const std::string& schema, int format)
    : File(file, Access::write) {
  try {
    set_up(schema, format);
  } catch (const WriteError&) {
    throw;
  } catch (const RunError& e) {
    throw InputError(
        fmt::format("{}; expected a folder that can be written, and no other file of "
                    "this name in it",
                    e.what()));
  }
}

void Database::set_up(const std::string& schema, int format) {
  execute("PRAGMA foreign_keys = ON");
  Transaction transaction(*this);
  Statement tables(*this, "SELECT count(*) FROM sqlite_master");
  tables.next();
  const bool fresh = tables.integer(0) == 0;
  if (!fresh) return require_format(format);
  execute(schema);
  execute(fmt::format("PRAGMA user_version = {}", format));
  transaction.commit();
}

Database::Database(const std::string& file, int format) : File(file, Access::read) {
  require_format(format);
}

void Database::require_format(int format) {
  if (sqlite::schema_version(*this) != format)
    throw InputError(fmt::format(
        "{}: is of another version of Firn, or no file of it; expected another folder", name()));
}

}  // namespace firn
