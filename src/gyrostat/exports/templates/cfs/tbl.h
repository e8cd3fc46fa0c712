/* Table of the parameters of @app@. */
#ifndef @APP@_TBL_H
#define @APP@_TBL_H

#include "@app@.h"

#define @APP@_TABLE_NAME "Parameters"
#define @APP@_TABLE_FILE "/cf/@app@.tbl"

typedef struct
{
@members@
} @APP@_Parameters_t;

#endif
