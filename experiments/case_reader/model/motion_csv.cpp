#include "experiments/case_reader/model/motion_csv.h"

#include "experiments/text/csv/csv_reader.h"

namespace firn {

MotionCsv read_motion_csv(const std::string& file, const std::string& time_column,
                          const std::string& position_column, const Dimension& position) {
  const std::vector<CsvRow> rows = read_csv_table(file);
  const CsvColumn time = find_csv_column(file, rows.front(), time_column, dimension::time);
  const CsvColumn moved = find_csv_column(file, rows.front(), position_column, position);
  MotionCsv table;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    table.times.push_back(csv_number(file, rows[i], time));
    table.positions.push_back(csv_number(file, rows[i], moved));
    table.lines.push_back(rows[i].line);
  }
  return table;
}

}  // namespace firn
