// SPDX-License-Identifier: BSD-3-Clause
// The one annotation of functions that must also compile for an accelerator.
#pragma once

#if defined(__CUDACC__) || defined(__HIPCC__)
#define TILTH_FUNCTION __host__ __device__ inline
#else
#define TILTH_FUNCTION inline
#endif
