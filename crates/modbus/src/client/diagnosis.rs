//! The registers in which a gateway shows what the ring's master says.

use encoring_ring::diagnostics::Diagnosis;

use super::wire::Deadline;
use super::{Core, at_offset};
use crate::address::{DiagnosisPlaces, Way};
use crate::error::ModbusError;
use crate::place::RegisterPlace;

impl Core {
    /// Reads the registers that the address names; none if it names none.
    pub(super) async fn diagnosis(&mut self, deadline: Deadline) -> Result<Diagnosis, ModbusError> {
        let DiagnosisPlaces { status, parameter } = self.address.diagnosis;
        let result = match (status, parameter) {
            // Of the same moment, where they can be.
            (Some(first), Some(second)) if at_offset(first, 1) == Some(second) => {
                self.pair(first, deadline).await.map(|[status, parameter]| (Some(status), Some(parameter)))
            }
            (Some(second), Some(first)) if at_offset(first, 1) == Some(second) => {
                self.pair(first, deadline).await.map(|[parameter, status]| (Some(status), Some(parameter)))
            }
            (status, parameter) => self.apart(status, parameter, deadline).await,
        };
        let (status, parameter) = self.checked(result)?;
        Ok(Diagnosis { status, parameter })
    }

    async fn apart(
        &mut self,
        status: Option<RegisterPlace>,
        parameter: Option<RegisterPlace>,
        deadline: Deadline,
    ) -> Result<(Option<u16>, Option<u16>), ModbusError> {
        let mut read = [None; 2];
        for (value, place) in read.iter_mut().zip([status, parameter]) {
            if let Some(place) = place {
                *value = Some(self.single(place, deadline).await?);
            }
        }
        let [status, parameter] = read;
        Ok((status, parameter))
    }

    /// One register. On a serial line a single one is asked for by its marker alone, so there it is read with a
    /// neighbour.
    async fn single(&mut self, place: RegisterPlace, deadline: Deadline) -> Result<u16, ModbusError> {
        if let Way::Tcp { .. } = self.address.way {
            let registers = self.read_piece(place, 1, deadline).await?;
            return Ok(registers.first().copied().unwrap_or_default());
        }
        let after = match at_offset(place, 1) {
            Some(_) => self.pair(place, deadline).await.map(|[value, _]| value),
            None => Err(refused(place)),
        };
        match (after, place.first.checked_sub(1)) {
            (Err(ModbusError::Refused { exception: 2, .. }), Some(first)) => {
                self.pair(RegisterPlace { first, ..place }, deadline).await.map(|[_, value]| value)
            }
            (after, _) => after,
        }
    }

    async fn pair(&mut self, place: RegisterPlace, deadline: Deadline) -> Result<[u16; 2], ModbusError> {
        let registers = self.read_piece(place, 2, deadline).await?;
        // A read brings as many as were asked for, or an error.
        Ok(registers.first_chunk().copied().unwrap_or_default())
    }
}

/// There is no register behind the last.
fn refused(place: RegisterPlace) -> ModbusError {
    ModbusError::Refused { function: super::reading(place.table), register: place.first, exception: 2 }
}
