#include "experiments/case_reader/case_from_results.h"

#include "experiments/case_reader/read_case.h"

namespace firn {

Case read_case(const Recording& recording) {
  Case c = read_case_text(recording.case_text(), recording.file(), ".", {}, {}, OldNames::accept);
  recording.check_case(c);
  return c;
}

}  // namespace firn
