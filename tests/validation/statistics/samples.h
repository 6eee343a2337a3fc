// Data that several tests of the statistics use.
#pragma once

#include "validation/statistics/distributions.h"

namespace firn::samples {

// Freireich et al. (1963): weeks of remission under 6-mercaptopurine and under placebo, the
// textbook case of both (Kalbfleisch and Prentice, chapter 1).
inline const CensoredTimes treated{{6, 6, 6, 7, 10, 13, 16, 22, 23},
                                   {6, 9, 10, 11, 17, 19, 20, 25, 32, 32, 34, 35}};
inline const CensoredTimes placebo{
    {1, 1, 2, 2, 3, 4, 4, 5, 5, 8, 8, 8, 8, 11, 11, 12, 12, 15, 17, 22, 23}, {}};

}  // namespace firn::samples
