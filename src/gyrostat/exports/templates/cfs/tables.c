/* Parameters of @app@ as they were designed. */
#include "@app@_tbl.h"
#include "cfe_tbl_filedef.h"

#include <math.h>

@APP@_Parameters_t @APP@_Parameters = {
@values@
};

CFE_TBL_FILEDEF(@APP@_Parameters, @APP@.Parameters, Parameters as designed, @app@.tbl)
